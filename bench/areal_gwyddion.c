/* SPDX-License-Identifier: GPL-3.0-or-later
 * Areal numbers of a height map by Gwyddion's library, as a peer of hdengine.surfaces.texture: see areal_numbers.py.
 * areal_gwyddion MAP [CUTOFF]: MAP holds columns, rows (int64), width and height of a point, then heights row by row (double, m).
 * Prints one line "name value" per number; writes MAP.filtered, the map less the Gaussian mean surface of CUTOFF [m], if given.
 * cc areal_gwyddion.c -o areal_gwyddion $(pkg-config --cflags --libs gwyddion) -lm (Debian: libgwyddion20-dev) */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <libgwyddion/gwyddion.h>
#include <libprocess/gwyprocess.h>
#include <libprocess/gwyshapefitpreset.h>

static GwyDataField *read_map(const char *path)
{
    int64_t n[2];
    double step[2];
    FILE *file = fopen(path, "rb");
    if (!file || fread(n, sizeof n, 1, file) != 1 || fread(step, sizeof step, 1, file) != 1)
        exit(3);
    GwyDataField *map = gwy_data_field_new((gint)n[0], (gint)n[1], n[0] * step[0], n[1] * step[1], FALSE);
    if (fread(gwy_data_field_get_data(map), sizeof(double), (size_t)(n[0] * n[1]), file) != (size_t)(n[0] * n[1]))
        exit(3);
    fclose(file);
    return map;
}

/* Shortest distance at which the autocorrelation falls to 0.2, over directions of half a degree. */
static double fall(GwyDataField *map)
{
    GwyDataField *acf = gwy_data_field_new_alike(map, FALSE);
    gwy_data_field_2dacf(map, acf);
    double dx = gwy_data_field_get_dx(acf), dy = gwy_data_field_get_dy(acf), best = INFINITY;
    int nx = gwy_data_field_get_xres(acf), ny = gwy_data_field_get_yres(acf), cx = nx / 2, cy = ny / 2;
    double top = gwy_data_field_get_val(acf, cx, cy), step = 0.25 * fmin(dx, dy);
    for (int k = 0; k < 360; k++) {
        double angle = (k - 180) * G_PI / 360;
        for (double r = step; ; r += step) {
            double x = cx + r * cos(angle) / dx + 0.5, y = cy + r * sin(angle) / dy + 0.5;
            if (x >= nx - 1 || y >= ny - 1 || y < 1)
                break;
            if (gwy_data_field_get_dval(acf, x, y, GWY_INTERPOLATION_LINEAR) <= 0.2 * top) {
                best = fmin(best, r);
                break;
            }
        }
    }
    g_object_unref(acf);
    return best;
}

static void cylinder(GwyDataField *map)
{
    gwy_resource_class_load(g_type_class_ref(GWY_TYPE_SHAPE_FIT_PRESET));
    GwyShapeFitPreset *shape = gwy_inventory_get_item(gwy_shape_fit_presets(), "Cylinder (lying)");
    if (!shape)
        return;
    int nx = gwy_data_field_get_xres(map), ny = gwy_data_field_get_yres(map);
    guint n = (guint)(nx * ny), count = gwy_shape_fit_preset_get_nparams(shape);
    GwyXYZ *points = g_new(GwyXYZ, n);
    for (guint i = 0; i < n; i++) {
        points[i].x = (i % nx + 0.5) * gwy_data_field_get_dx(map);
        points[i].y = (i / nx + 0.5) * gwy_data_field_get_dy(map);
        points[i].z = gwy_data_field_get_data_const(map)[i];
    }
    double *p = g_new0(double, count), rss = -1;
    gwy_shape_fit_preset_setup(shape, points, n, p);
    if (gwy_shape_fit_preset_guess(shape, points, n, p)) {
        gwy_math_nlfit_free(gwy_shape_fit_preset_fit(shape, NULL, points, n, p, NULL, &rss));
        for (guint i = 0; i < count; i++)
            printf("cylinder_%s %.17g\n", gwy_shape_fit_preset_get_param_name(shape, i), p[i]);
        for (guint i = 0; i < gwy_shape_fit_preset_get_nsecondary(shape); i++)
            printf("cylinder_%s %.17g\n", gwy_shape_fit_preset_get_secondary_name(shape, i),
                   gwy_shape_fit_preset_get_secondary_value(shape, i, p));
        printf("cylinder_rms %.17g\n", sqrt(rss / n));
    }
    g_free(p);
    g_free(points);
}

int main(int argc, char **argv)
{
    if (argc < 2)
        return 2;
    gwy_process_type_init();
    GwyDataField *map = read_map(argv[1]);
    int nx = gwy_data_field_get_xres(map), ny = gwy_data_field_get_yres(map);
    cylinder(map);
    double a, bx, by, avg, ra, rms, skew, kurtosis;
    gwy_data_field_fit_plane(map, &a, &bx, &by);
    gwy_data_field_plane_level(map, a, bx, by);
    gwy_data_field_add(map, -gwy_data_field_get_avg(map));
    gwy_data_field_get_stats(map, &avg, &ra, &rms, &skew, &kurtosis);
    double flat = gwy_data_field_get_xreal(map) * gwy_data_field_get_yreal(map);
    printf("sa_m %.17g\nsq_m %.17g\nssk %.17g\nsku %.17g\n", ra, rms, skew, kurtosis + 3);
    printf("sp_m %.17g\nsv_m %.17g\n", gwy_data_field_get_max(map), -gwy_data_field_get_min(map));
    printf("sdr %.17g\nsdq %.17g\nsal_m %.17g\n", gwy_data_field_get_surface_area(map) / flat - 1,
           gwy_data_field_get_surface_slope(map), fall(map));
    GwyDataField *psdf = gwy_data_field_new_alike(map, FALSE);
    gwy_data_field_2dpsdf(map, psdf, GWY_WINDOWING_HANN, 0);
    GwyDataLine *angles = gwy_data_field_psdf_to_angular_spectrum(psdf, 0);
    int m = gwy_data_line_get_res(angles), best = 0;
    for (int i = 0; i < m; i++)
        if (gwy_data_line_get_val(angles, i) > gwy_data_line_get_val(angles, best))
            best = i;
    printf("std_rad %.17g\n", gwy_data_line_get_offset(angles) + (best + 0.5) * gwy_data_line_get_real(angles) / m);
    if (argc > 2) {
        GwyDataField *mean = gwy_data_field_duplicate(map);
        double sigma = atof(argv[2]) * sqrt(log(2) / G_PI) / sqrt(2 * G_PI);
        gwy_data_field_filter_gaussian(mean, sigma / gwy_data_field_get_dx(map));
        gwy_data_field_subtract_fields(mean, map, mean);
        char *path = g_strconcat(argv[1], ".filtered", NULL);
        FILE *file = fopen(path, "wb");
        if (!file || fwrite(gwy_data_field_get_data_const(mean), sizeof(double), (size_t)(nx * ny), file) != (size_t)(nx * ny))
            return 3;
        fclose(file);
    }
    return 0;
}
