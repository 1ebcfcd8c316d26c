/* The plant as the study's methods see it; equations of Kornienko et al. (2013).
 *
 * State: i_A, i_B, alpha, omega, delta = alpha - G alpha_g, v = delta', z, z'. */

enum { I_A, I_B, ALPHA, OMEGA, DELTA, V, Z, Z_DOT, STATES };

typedef struct { /* problem.PARAMETERS, then the constants */
    double R, L, k_m, static_, detent[4], coulomb, viscous, K_s, D, K_res, w0, zeta;
    double half_poles, J_rot, G, J_m;
} Plant;

typedef struct {
    double x[STATES], s, c; /* s, c: sine and cosine of the electrical angle */
    double sign;            /* of the speed; 0 while the rotor sticks */
    double u[2];
    long switches, evaluations;
} State;

/* The electrical angle's sine and cosine at alpha, beside those of x. */
INLINE void turned(const Plant *p, const State *x, double alpha, double *s, double *c)
{
    const double e = p->half_poles * (alpha - x->x[ALPHA]), q = e * e;
    if (__builtin_expect(fabs(e) > 0.1, 0)) {
        sincos(p->half_poles * alpha, s, c);
        return;
    }
    const double sine = e * (1 + q * (-1.0 / 6 + q * (1.0 / 120 - q * (1.0 / 5040))));
    const double versine = q * (0.5 - q * (1.0 / 24 - q * (1.0 / 720 - q * (1.0 / 40320))));
    const double s0 = x->s, c0 = x->c; /* s, c may point into x */
    *s = s0 + (c0 * sine - s0 * versine);
    *c = c0 - (s0 * sine + c0 * versine);
}

INLINE double detents(const Plant *p, double s, double c)
{
    const double s2 = 2 * s * c, c2 = 1 - 2 * s * s;
    return p->detent[0] * 2 * s2 * c2 + p->detent[1] * (1 - 2 * s2 * s2)
         + p->detent[2] * s2 + p->detent[3] * c2;
}

INLINE double gear(const Plant *p, const double *x)
{
    return (p->K_s * x[DELTA] + p->D * x[V]) / (p->G * p->G);
}

/* T_mot - T_rg */
INLINE double drive(const Plant *p, const double *x, double s, double c)
{
    return p->k_m * (x[I_A] * s + x[I_B] * c) - detents(p, s, c) - gear(p, x);
}

INLINE double T_res(const Plant *p, double sign, const double *x, double s, double c)
{
    const double T_fr = sign * p->coulomb + p->viscous * x[OMEGA];
    return sign != 0 ? drive(p, x, s, c) - T_fr : 0;
}

/* Rates of the first n states; returns T_res. */
INLINE double rates(const Plant *p, const State *at, int n, const double *x, double s, double c, double *d)
{
    const double T = T_res(p, at->sign, x, s, c), b = p->G * p->G / p->J_m * gear(p, x);
    d[I_A] = (at->u[0] - p->R * x[I_A] - p->k_m * x[OMEGA] * s) / p->L;
    d[I_B] = (at->u[1] - p->R * x[I_B] - p->k_m * x[OMEGA] * c) / p->L;
    d[ALPHA] = x[OMEGA];
    d[OMEGA] = T / p->J_rot;
    d[DELTA] = x[V];
    d[V] = d[OMEGA] - b;
    if (n == STATES) {
        d[Z] = x[Z_DOT];
        d[Z_DOT] = p->w0 * p->w0 * (p->K_res * T - x[Z]) - 2 * p->zeta * p->w0 * x[Z_DOT];
    }
    return T;
}

/* dT_res/dt at x, for its rates d. */
INLINE double T_res_rate(
    const Plant *p, double sign, const double *x, double s, double c, const double *d)
{
    const double s2 = 2 * s * c, c2 = 1 - 2 * s * s;
    const double by_angle = p->k_m * (x[I_A] * c - x[I_B] * s)
        - 4 * (p->detent[0] * (1 - 2 * s2 * s2) - p->detent[1] * 2 * s2 * c2)
        - 2 * (p->detent[2] * c2 - p->detent[3] * s2);
    const double T = p->k_m * (d[I_A] * s + d[I_B] * c) + p->half_poles * x[OMEGA] * by_angle
        - p->viscous * d[OMEGA] - (p->K_s * d[DELTA] + p->D * d[V]) / (p->G * p->G);
    return sign != 0 ? T : 0;
}
