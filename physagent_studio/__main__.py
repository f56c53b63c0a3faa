"""`python -m physagent_studio` is the command line."""

from physagent_studio.cli import main

if __name__ == "__main__":
    main()
