"""For every test: a flight writes its page only where a test asks for it, for a page takes longer than many flights."""

from __future__ import annotations

import os

os.environ.setdefault("COMPANION_REPORT", "0")
