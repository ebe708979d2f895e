/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Kernel of hd_large_strain.c for one width of register: BYTES/8 sectors at once. */
typedef double NAME(lanes) __attribute__((vector_size(BYTES), aligned(8)));
#define LANES NAME(lanes)
#define AT(x, i) (*(LANES *)((x) + 8 * (i) + l))

/* Displacements of nodes along x, y, z. */
TARGET static inline void NAME(turn_nodes)(int nodes, int l, const double *restrict turn, const int *restrict at,
                                           const double *restrict u, LANES *restrict v)
{
  for (int a = 0; a < nodes; a++) {
    const int b = 3 * (at[a] - 1);
    v[3 * a] = turn[2 * a] * AT(u, b) - turn[2 * a + 1] * AT(u, b + 1);
    v[3 * a + 1] = turn[2 * a + 1] * AT(u, b) + turn[2 * a] * AT(u, b + 1);
    v[3 * a + 2] = AT(u, b + 2);
  }
}

/* Their gradient at a point. */
TARGET static inline void NAME(find_gradient)(int nodes, const double *restrict g, const LANES *restrict v, LANES h[3][3])
{
  LANES sum[3][3] = {{{0}}}; /* in registers */
  for (int a = 0; a < nodes; a++)
    for (int j = 0; j < 3; j++)
      for (int i = 0; i < 3; i++) sum[i][j] += g[j * nodes + a] * v[3 * a + i];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) h[i][j] = sum[i][j];
}

/* Weighted stresses at all points of strains there. */
TARGET static inline void NAME(find_stress)(int modes, double lambda, double mu, const double *restrict weight,
                                            const double *restrict eased, const LANES *restrict e, LANES *restrict s)
{
  for (int p = 0; p < 8; p++) {
    const LANES volume = lambda * (e[6 * p] + e[6 * p + 1] + e[6 * p + 2]);
    for (int i = 0; i < 3; i++) {
      s[6 * p + i] = weight[p] * (volume + 2 * mu * e[6 * p + i]);
      s[6 * p + 3 + i] = weight[p] * (mu * e[6 * p + 3 + i]);
    }
  }
  LANES amount[9];
  for (int m = 0; m < modes; m += 3) { /* three modes read e once; one sum each would wait for itself */
    LANES part[3][4] = {{{0}}};
    for (int i = 0; i < 48; i += 4)
      for (int q = 0; q < 4; q++)
        for (int n = 0; n < 3; n++) part[n][q] += eased[48 * (m + n) + i + q] * e[i + q];
    for (int n = 0; n < 3; n++) amount[m + n] = (part[n][0] + part[n][1]) + (part[n][2] + part[n][3]);
  }
  for (int i = 0; i < 48; i += 8) {
    LANES left[8];
    for (int q = 0; q < 8; q++) left[q] = s[i + q];
    for (int m = 0; m < modes; m++)
      for (int q = 0; q < 8; q++) left[q] -= eased[48 * m + i + q] * amount[m];
    for (int q = 0; q < 8; q++) s[i + q] = left[q];
  }
}

TARGET static void NAME(hd_large_strain)(int nodes, int modes, double lambda, double mu, const double *restrict turn,
                                         const double *restrict g, const double *restrict weight, const double *restrict eased,
                                         const double *restrict pushed, const int *restrict at, const double *restrict u,
                                         double *restrict stress, double *restrict energy, double *restrict f,
                                         double *restrict k, const double *restrict v, double *restrict keep,
                                         const double *restrict kept)
{
  static const int next[3] = {1, 2, 0}, place[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  const int n = 3 * nodes;
  for (int l = 0; l < 8; l += BYTES / 8) {
    LANES def[8][3][3], e[48], s[48], moved[60], force[60] = {0};
    if (kept) {
      for (int p = 0; p < 8; p++) {
        for (int i = 0; i < 9; i++) def[p][i / 3][i % 3] = AT(kept, 15 * p + i);
        for (int i = 0; i < 6; i++) s[6 * p + i] = AT(kept, 15 * p + 9 + i);
      }
    } else {
      NAME(turn_nodes)(nodes, l, turn, at, u, moved);
      for (int p = 0; p < 8; p++) {
        LANES h[3][3], (*const d)[3] = def[p];
        NAME(find_gradient)(nodes, g + 3 * p * nodes, moved, h);
        for (int i = 0; i < 3; i++) {
          const int j = next[i];
          e[6 * p + i] = h[i][i] + 0.5 * (h[0][i] * h[0][i] + h[1][i] * h[1][i] + h[2][i] * h[2][i]);
          e[6 * p + 3 + i] = h[i][j] + h[j][i] + (h[0][i] * h[0][j] + h[1][i] * h[1][j] + h[2][i] * h[2][j]);
          for (int q = 0; q < 3; q++) d[i][q] = h[i][q] + (i == q);
        }
      }
      NAME(find_stress)(modes, lambda, mu, weight, eased, e, s);
      if (keep)
        for (int p = 0; p < 8; p++) {
          for (int i = 0; i < 9; i++) AT(keep, 15 * p + i) = def[p][i / 3][i % 3];
          for (int i = 0; i < 6; i++) AT(keep, 15 * p + 9 + i) = s[6 * p + i];
        }
    }
    if (stress)
      for (int i = 0; i < 48; i++) AT(stress, i) = s[i] / weight[i / 6];
    if (energy) {
      LANES work = {0};
      for (int i = 0; i < 48; i++) work += s[i] * e[i];
      AT(energy, 0) += 0.5 * work;
    }
    if (!f) continue;
    LANES more[8][3][3], added[48];
    if (v) {
      NAME(turn_nodes)(nodes, l, turn, at, v, moved);
      for (int p = 0; p < 8; p++) {
        LANES (*const d)[3] = def[p], (*const h)[3] = more[p];
        NAME(find_gradient)(nodes, g + 3 * p * nodes, moved, h);
        for (int i = 0; i < 3; i++) {
          const int j = next[i];
          e[6 * p + i] = d[0][i] * h[0][i] + d[1][i] * h[1][i] + d[2][i] * h[2][i];
          e[6 * p + 3 + i] = d[0][i] * h[0][j] + d[1][i] * h[1][j] + d[2][i] * h[2][j] + d[0][j] * h[0][i] + d[1][j] * h[1][i]
                             + d[2][j] * h[2][i];
        }
      }
      NAME(find_stress)(modes, lambda, mu, weight, eased, e, added);
    }
    for (int p = 0; p < 8; p++) {
      const LANES *const t = (v ? added : s) + 6 * p;
      LANES first[3][3] = {{{0}}};
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          for (int q = 0; q < 3; q++) first[i][j] += def[p][i][q] * t[place[q][j]];
      if (v)
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++)
            for (int q = 0; q < 3; q++) first[i][j] += more[p][i][q] * s[6 * p + place[q][j]];
      for (int a = 0; a < nodes; a++)
        for (int j = 0; j < 3; j++)
          for (int i = 0; i < 3; i++) force[3 * a + i] += g[(3 * p + j) * nodes + a] * first[i][j];
    }
    for (int a = 0; a < nodes; a++) {
      const int b = 3 * (at[a] - 1);
      AT(f, b) += turn[2 * a] * force[3 * a] + turn[2 * a + 1] * force[3 * a + 1];
      AT(f, b + 1) += turn[2 * a] * force[3 * a + 1] - turn[2 * a + 1] * force[3 * a];
      AT(f, b + 2) += force[3 * a + 2];
    }
    if (!k) continue;
    /* of each point and node: F g, S g; of each point F F^T; of each mode and node what it does to the strains */
    LANES fg[8][20][3], sg[8][20][3], ff[8][3][3], mode[9][20][3];
    for (int p = 0; p < 8; p++) {
      for (int a = 0; a < nodes; a++)
        for (int i = 0; i < 3; i++) {
          fg[p][a][i] = sg[p][a][i] = (LANES){0};
          for (int j = 0; j < 3; j++) {
            fg[p][a][i] += g[(3 * p + j) * nodes + a] * def[p][i][j];
            sg[p][a][i] += g[(3 * p + j) * nodes + a] * s[6 * p + place[i][j]];
          }
        }
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          ff[p][i][j] = def[p][i][0] * def[p][j][0] + def[p][i][1] * def[p][j][1] + def[p][i][2] * def[p][j][2];
    }
    for (int m = 0; m < modes; m++)
      for (int a = 0; a < nodes; a++) {
        LANES x[3] = {{0}};
        for (int p = 0; p < 8; p++)
          for (int j = 0; j < 3; j++)
            for (int i = 0; i < 3; i++) x[i] += pushed[((8 * m + p) * nodes + a) * 3 + j] * def[p][i][j];
        for (int i = 0; i < 3; i++) mode[m][a][i] = x[i];
      }
    for (int b = 0; b < nodes; b++)
      for (int a = 0; a <= b; a++) {
        LANES outer[3][3] = {{{0}}}, sum[3][3] = {{{0}}}, along = {0}, block[3][3];
        for (int p = 0; p < 8; p++) {
          const double *const ga = g + 3 * p * nodes + a, *const gb = g + 3 * p * nodes + b;
          const double meet = mu * weight[p] * (ga[0] * gb[0] + ga[nodes] * gb[nodes] + ga[2 * nodes] * gb[2 * nodes]);
          for (int i = 0; i < 3; i++) {
            const LANES x = weight[p] * fg[p][a][i];
            for (int j = 0; j < 3; j++) outer[i][j] += x * fg[p][b][j];
            for (int j = i; j < 3; j++) sum[i][j] += meet * ff[p][i][j];
            along += ga[i * nodes] * sg[p][b][i];
          }
        }
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++)
            block[i][j] = lambda * outer[i][j] + mu * outer[j][i] + (i > j ? sum[j][i] : sum[i][j]);
        for (int i = 0; i < 3; i++) block[i][i] += along;
        for (int m = 0; m < modes; m++)
          for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) block[i][j] -= mode[m][a][i] * mode[m][b][j];
        for (int j = 0; j < 3; j++) {
          const LANES x = block[0][j], y = block[1][j];
          block[0][j] = turn[2 * a] * x + turn[2 * a + 1] * y;
          block[1][j] = turn[2 * a] * y - turn[2 * a + 1] * x;
        }
        for (int i = 0; i < 3; i++) {
          const LANES x = block[i][0], y = block[i][1];
          block[i][0] = turn[2 * b] * x + turn[2 * b + 1] * y;
          block[i][1] = turn[2 * b] * y - turn[2 * b + 1] * x;
        }
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++) {
            if (a == b && j < i) block[i][j] = block[j][i];
            AT(k, (3 * b + j) * n + 3 * a + i) = block[i][j];
            AT(k, (3 * a + i) * n + 3 * b + j) = block[i][j];
          }
      }
  }
}
#undef AT
#undef LANES
