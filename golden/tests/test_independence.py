import ast
from pathlib import Path

GOLDEN = Path(__file__).resolve().parents[1]


def test_golden_imports_nothing_of_ours_but_itself():
    files = list(GOLDEN.rglob("*.py"))
    assert len(files) > 10
    for path in files:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0
                names = [node.module or ""]
            for name in names:
                if name.split(".")[0] == "triaxis":
                    assert name.startswith("triaxis.golden"), f"{path.name} imports {name}"
