"""The bench of physics prints every figure and writes them down."""

from physagent_studio.benchmark.physics import bench as physics
from physagent_studio.benchmark.physics.bench import malformed


def test_malformed_programs_are_read_or_refused_in_order():
    rows = malformed(150)
    assert [row.ok for row in rows] == [True, True, True]
    assert rows[0].value == 150


def test_the_bench_writes_a_page_with_every_row(tmp_path, monkeypatch):
    quick = {name: physics.FIGURES[name] for name in ("projectile", "angled_force")}
    monkeypatch.setattr(physics, "FIGURES", quick)
    monkeypatch.setattr(physics, "DOSE", 50)
    rows = physics.bench(out=tmp_path / "physics.md")
    page = (tmp_path / "physics.md").read_text()
    names = [row.name for row in rows]
    assert {"projectile, 3.4 s", "malformed programs read"} <= set(names)
    assert all(f"| {row.name} |" in page for row in rows)
    assert page.count("| ✓ |") == len(rows)
