// Printed by gen_minimax.py.
/// sin(r) = r + r t (c0 + c1 t + c2 t^2), t = r^2, |r| <= pi/4
static const double minimax_sin[] = {
    -1.6666664656e-01,
    8.3327471044e-03,
    -1.9587639035e-04,
};
/// Largest error of it in exact arithmetic, rounded up.
static const double minimax_sin_error = 9.7e-09;

/// cos(r) = 1 + t (c0 + c1 t + c2 t^2 + c3 t^3), c0 set to -1/2
static const double minimax_cos[] = {
    -5.0000000000e-01,
    4.1666650597e-02,
    -1.3887586565e-03,
    2.4463452534e-05,
};
/// Largest error of it in exact arithmetic, rounded up.
static const double minimax_cos_error = 3.3e-10;

/// atan(r) = r + r t (c0 + .. + c6 t^6), |r| <= 1
static const double minimax_atan[] = {
    -3.3333267267e-01,
    1.9993467898e-01,
    -1.4176429835e-01,
    1.0394261806e-01,
    -6.6890806270e-02,
    2.9852263318e-02,
    -6.3439741117e-03,
};
/// Largest error of it in exact arithmetic, rounded up.
static const double minimax_atan_error = 3.6e-07;

