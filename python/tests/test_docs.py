"""docs/python.md, example by example."""

import re

from conftest import ROOT


def test_the_examples_run_as_they_stand(url, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SERVER", url)
    examples = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.DOTALL)
    known = {}
    for example in examples:
        exec(compile(example, "docs/python.md", "exec"), known)
    assert len(examples) == 6 and len(known["season"]) == 2
    said = capsys.readouterr().out
    assert "mass_rear_kg: expected a number" in said and "z_f 0 arrays, sample 1" in said
