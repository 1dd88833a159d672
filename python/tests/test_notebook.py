"""The notebook runs from top to bottom and shows what it is meant to."""

import nbclient
import nbformat
from conftest import ROOT


def test_the_notebook_runs():
    path = ROOT / "python/examples/ride_and_season.ipynb"
    notebook = nbformat.read(path, as_version=4)
    # As Jupyter does: in the notebook's folder, from which modules are imported first.
    where = {"metadata": {"path": str(path.parent)}}
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=where).execute()
    outputs = {cell.id: cell.get("outputs", []) for cell in notebook.cells}
    shown = [output.data for output in outputs["identify"] if "data" in output]
    assert "coulomb_friction" in shown[0]["text/html"] and "<svg" in shown[0]["text/html"]
    drawn = [output for cell in ("series", "trend") for output in outputs[cell] if "image/png" in output.get("data", {})]
    assert len(drawn) == 2
