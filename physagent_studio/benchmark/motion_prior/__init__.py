"""What leaves the product held against analytic truth, OpenCV's flow and MuJoCo's renderer."""
