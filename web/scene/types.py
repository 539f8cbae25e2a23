"""Words the drawing modules share."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.integer[Any]]
Segments = NDArray[np.float32]  # line segments as viser takes them, (n, 2 ends, 3)
Change = tuple[Any, str, Any]  # node handle, property, new value
