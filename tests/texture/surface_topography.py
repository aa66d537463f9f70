"""Parameters of a texture by SurfaceTopography, as JSON: what it reads from the X3P and from the ASCII matrix.

    python surface_topography.py texture.x3p texture.asc
"""

import json
import sys

import numpy as np
from SurfaceTopography import open_topography


def parameters(name):
    topography = open_topography(name).topography()
    micro = {"m": 1e6, "mm": 1e3, "µm": 1.0, "um": 1.0, "nm": 1e-3}[topography.unit]
    # What the package calls height is the mean plane by least squares.
    level = topography.detrend("height")
    # Nodes beyond the surface are masked.
    gaps = topography.has_undefined_data
    heights = np.ma.masked_invalid(level.heights()).compressed()
    return {
        "on_surface": len(heights),
        "nodes": list(topography.nb_grid_pts),
        "size_mm": [side * micro * 1e-3 for side in topography.physical_sizes],
        "sq_um": level.rms_height_from_area() * micro,
        "rq_along_um": None if gaps else level.rms_height_from_profile() * micro,
        "sa_um": float(np.mean(np.abs(heights))) * micro,
        "sz_um": float(np.ptp(heights)) * micro,
        "ssk": float(np.mean(heights**3) / np.mean(heights**2) ** 1.5),
        "sku": float(np.mean(heights**4) / np.mean(heights**2) ** 2),
    }


print(json.dumps([parameters(name) for name in sys.argv[1:]]))
