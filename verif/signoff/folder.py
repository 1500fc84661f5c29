"""Where a sign-off leaves its results."""

from triaxis.sim.paths import BUILD

FOLDER = BUILD / "signoff"
RESULT = FOLDER / "signoff.json"
PAGE = FOLDER / "index.html"
