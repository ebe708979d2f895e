/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces and tangent of one cell under large displacements, for the same cell of eight sectors (hd_total_lagrangian). */
#define KERNEL "../../contact/elements/hd_large_strain.h"
#include "../../common/base/hd_lanes.h"

/* most: bytes of a vector register, 0: any; nodes: 8 or 20; modes: at most 9; lambda, mu: of Lame; turn (2, nodes): cosine and
   sine of the directions of the dofs; g (nodes, 3, 8 points): gradients; weight (8): volumes; eased (6, 8 points, modes): what the
   modes take; pushed (3, nodes, 8 points, modes): the same as stresses times gradients; u (8 sectors, 3, nodes): displacements;
   stress (8 sectors, 6, 8 points), energy (8 sectors), f (8 sectors, 3, nodes): forces; k (8 sectors, 3 nodes, 3 nodes): tangent,
   or null; v (8 sectors, 3, nodes): what the tangent is multiplied by, f gets the product, or null */
void hd_large_strain(int most, int nodes, int modes, double lambda, double mu, const double *restrict turn,
                     const double *restrict g, const double *restrict weight, const double *restrict eased,
                     const double *restrict pushed, const double *restrict u, double *restrict stress, double *restrict energy,
                     double *restrict f, double *restrict k, const double *restrict v)
{
  PICK(most, hd_large_strain, nodes, modes, lambda, mu, turn, g, weight, eased, pushed, u, stress, energy, f, k,
       v);
}
