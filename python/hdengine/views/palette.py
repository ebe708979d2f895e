# SPDX-License-Identifier: GPL-3.0-or-later
"""One family of colours of all figures, those of a report included: lines, parts of a drive, maps."""

COLOURS = ("#2f6690", "#d1495b", "#c8963e", "#4f8a6b", "#7a5195", "#3aa0a0", "#8a5a44", "#6b7280")
PARTS = {"cup": "#2f6690", "ring": "#c8963e", "balls": "#e3c27e", "teeth": "#4f8a6b", "spline": "#9cc3ac", "gaps": "#d1495b",
         "slip": "#e58b97", "joint": "#f3c6cc"}
REFERENCE = "#6b7280"   # what stands beside a result
PRESSURE, SIGNED = "viridis", "RdBu_r"   # names of matplotlib's maps
# 16 steps of PRESSURE
STEPS = ("#470d60", "#482374", "#453781", "#3e4989", "#375b8d", "#2f6b8e", "#297a8e", "#23898e", "#1f988b", "#22a785", "#32b67a",
         "#4ec36b", "#70cf57", "#98d83e", "#c2df23", "#ece51b")
