/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces and tangent of one cell under large displacements, for the same cell of eight sectors (hd_total_lagrangian). */
#define KERNEL "../../contact/elements/hd_large_strain.h"
#include "../../common/base/hd_lanes.h"

/* most: bytes of a vector register, 0: any; nodes: 8 or 20; modes: at most 9; lambda, mu: of Lame; turn (2, nodes): cosine and
   sine of the directions of the dofs; g (nodes, 3, 8 points): gradients; weight (8): volumes; eased (6, 8 points, modes): what the
   modes take; pushed (3, nodes, 8 points, modes): the same as stresses times gradients; at (nodes): places of the nodes in fields;
   u (8 sectors, 3, places): displacements; stress (8 sectors, 6, 8 points), or null; energy (8 sectors): added to, or null;
   f (8 sectors, 3, places): forces, added to, or null; k (8 sectors, 3 nodes, 3 nodes): tangent, or null; v (8 sectors, 3,
   places): what the tangent is multiplied by, f gets the product, or null; keep (8 sectors, 15, 8 points): gets gradients and
   weighted stresses that u makes, or null; kept: the same, taken in place of u, without stress and energy, or null */
void hd_large_strain(int most, int nodes, int modes, double lambda, double mu, const double *restrict turn,
                     const double *restrict g, const double *restrict weight, const double *restrict eased,
                     const double *restrict pushed, const int *restrict at, const double *restrict u, double *restrict stress,
                     double *restrict energy, double *restrict f, double *restrict k, const double *restrict v,
                     double *restrict keep, const double *restrict kept)
{
  PICK(most, hd_large_strain, nodes, modes, lambda, mu, turn, g, weight, eased, pushed, at, u, stress, energy, f, k, v, keep,
       kept);
}
