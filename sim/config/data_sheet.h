/// Keys of [motor] in the units of data sheets: each stands for one or two keys in SI units.
#ifndef RIG_DATA_SHEET_H
#define RIG_DATA_SHEET_H

/// The key, with its unit in its name; the keys it replaces (two if one value is for both axes); its conversion
/// (conversions.c); the factor of its unit.
#define DATA_SHEET_KEYS(X) X(poles, "pole_pairs", NULL, SCALED, 0.5) DATA_SHEET_VALUES(X)

/// All but the number of poles, which has a range of its own.
#define DATA_SHEET_VALUES(X)                                                                       \
    X(Rs_mOhm, "Rs_Ohm", NULL, SCALED, 1e-3)                                                       \
    X(R_line_line_Ohm, "Rs_Ohm", NULL, LINE_LINE, 1.0)                                             \
    X(R_line_line_mOhm, "Rs_Ohm", NULL, LINE_LINE, 1e-3)                                           \
    X(R_winding_Ohm, "Rs_Ohm", NULL, WINDING, 1.0)                                                 \
    X(R_winding_mOhm, "Rs_Ohm", NULL, WINDING, 1e-3)                                               \
    X(Ld_mH, "Ld_H", NULL, SCALED, 1e-3)                                                           \
    X(Ld_uH, "Ld_H", NULL, SCALED, 1e-6)                                                           \
    X(Lq_mH, "Lq_H", NULL, SCALED, 1e-3)                                                           \
    X(Lq_uH, "Lq_H", NULL, SCALED, 1e-6)                                                           \
    X(Ld_line_line_mH, "Ld_H", NULL, LINE_LINE, 1e-3)                                              \
    X(Ld_line_line_uH, "Ld_H", NULL, LINE_LINE, 1e-6)                                              \
    X(Lq_line_line_mH, "Lq_H", NULL, LINE_LINE, 1e-3)                                              \
    X(Lq_line_line_uH, "Lq_H", NULL, LINE_LINE, 1e-6)                                              \
    X(L_mH, "Ld_H", "Lq_H", SCALED, 1e-3)                                                          \
    X(L_uH, "Ld_H", "Lq_H", SCALED, 1e-6)                                                          \
    X(L_line_line_mH, "Ld_H", "Lq_H", LINE_LINE, 1e-3)                                             \
    X(L_line_line_uH, "Ld_H", "Lq_H", LINE_LINE, 1e-6)                                             \
    X(L_winding_mH, "Ld_H", "Lq_H", WINDING, 1e-3)                                                 \
    X(L_winding_uH, "Ld_H", "Lq_H", WINDING, 1e-6)                                                 \
    X(psi_mWb, "psi_Wb", NULL, SCALED, 1e-3)                                                       \
    X(KV_rpm_V, "psi_Wb", NULL, KV, 1.0)                                                           \
    X(ke_Vrms_krpm, "psi_Wb", NULL, VRMS_KRPM, 1.0)                                                \
    X(ke_Vpk_krpm, "psi_Wb", NULL, VRMS_KRPM, 0.70710678118654752)                                 \
    X(ke_V_Hz, "psi_Wb", NULL, V_HZ, 1.0)                                                          \
    X(kt_Nm_A, "psi_Wb", NULL, KT, 1.0)                                                            \
    X(kt_mNm_A, "psi_Wb", NULL, KT, 1e-3)                                                          \
    X(kt_Nm_Arms, "psi_Wb", NULL, KT, 0.70710678118654752)                                         \
    X(kt_ozin_A, "psi_Wb", NULL, KT, DATA_SHEET_ozin_Nm)                                           \
    X(J_gcm2, "J_kgm2", NULL, SCALED, 1e-7)                                                        \
    X(J_kgcm2, "J_kgm2", NULL, SCALED, 1e-4)                                                       \
    X(J_ozins2, "J_kgm2", NULL, SCALED, DATA_SHEET_ozin_Nm)

/// Ounce-force (28.349523125 g, 9.80665 m/s^2) times inch (25.4 mm).
#define DATA_SHEET_ozin_Nm (28.349523125e-3 * 9.80665 * 25.4e-3)

/// As written; NaN: not given.
typedef struct {
#define DATA_SHEET_FIELD(key, one, other, conversion, factor) double key;
    DATA_SHEET_KEYS(DATA_SHEET_FIELD)
#undef DATA_SHEET_FIELD
    int winding; ///< lode_winding_t, of the values of a winding
} data_sheet_t;

#endif
