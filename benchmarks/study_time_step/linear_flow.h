/* Methods with the whole linear part in closed form: coils, gear, viscous friction and housing.
 *
 * What is left is nonlinear in three channels: the two back-emfs, and the torque of coils, detents
 * and Coulomb friction. The flow of the linear part is the exponential of a block for alpha, omega,
 * delta, v, z, z' and of a scalar for the coils; phi_k are the functions of exponential
 * integrators, of the torque's channel. Taylor series, to rounding for the steps used here. */

enum { BLOCK = 6, TERMS = 14 };

typedef struct {
    double E[BLOCK][BLOCK], phi[4][BLOCK]; /* exp(h A); h phi_k(h A) b for k = 1, 2, 3 */
    double coil, coil_phi[4];
} Flow;

typedef struct {
    Flow half, whole;
} Flows;

INLINE void linear_part(const Plant *p, double sign, double A[BLOCK][BLOCK], double *b)
{
    const double w2 = p->w0 * p->w0, GG = p->G * p->G, moves = sign != 0 ? 1 / p->J_rot : 0;
    const double T[BLOCK] = {0, -p->viscous, -p->K_s / GG, -p->D / GG, 0, 0}; /* T_res by states */
    memset(A, 0, sizeof(double[BLOCK][BLOCK]));
    A[0][1] = sign != 0;
    A[2][3] = A[4][5] = 1;
    for (int i = 0; i < BLOCK; ++i) {
        A[1][i] = moves * T[i];
        A[3][i] = moves * T[i];
        A[5][i] = moves * p->J_rot * w2 * p->K_res * T[i];
    }
    A[3][2] -= p->K_s / p->J_m;
    A[3][3] -= p->D / p->J_m;
    A[5][4] -= w2;
    A[5][5] -= 2 * p->zeta * p->w0;
    for (int i = 0; i < BLOCK; ++i)
        b[i] = 0;
    b[1] = b[3] = moves;
    b[5] = moves * p->J_rot * w2 * p->K_res;
}

/* Add the Taylor series of h phi_k(h A) b, k = 1, 2, 3; the terms are h^(j+1) A^j b / (j + k)!. */
static void phi_series(const double A[BLOCK][BLOCK], const double *b, double h, double phi[4][BLOCK])
{
    double power[BLOCK], factorial[3] = {1, 2, 6};
    for (int i = 0; i < BLOCK; ++i)
        power[i] = h * b[i];
    memset(phi, 0, sizeof(double[4][BLOCK]));
    for (int j = 0; j < TERMS; ++j) {
        double next[BLOCK] = {0};
        for (int i = 0; i < BLOCK; ++i) {
            for (int k = 1; k <= 3; ++k)
                phi[k][i] += power[i] / factorial[k - 1];
            for (int l = 0; l < BLOCK; ++l)
                next[i] += h * A[i][l] * power[l];
        }
        memcpy(power, next, sizeof power);
        for (int k = 1; k <= 3; ++k)
            factorial[k - 1] *= j + 1 + k;
    }
}

static void exponential(const double A[BLOCK][BLOCK], double h, double E[BLOCK][BLOCK])
{
    double term[BLOCK][BLOCK] = {{0}};
    for (int i = 0; i < BLOCK; ++i)
        term[i][i] = 1;
    memcpy(E, term, sizeof term);
    for (int j = 1; j <= TERMS; ++j) {
        double next[BLOCK][BLOCK] = {{0}};
        for (int i = 0; i < BLOCK; ++i)
            for (int l = 0; l < BLOCK; ++l)
                for (int m = 0; m < BLOCK; ++m)
                    next[i][m] += h / j * A[i][l] * term[l][m];
        memcpy(term, next, sizeof term);
        for (int i = 0; i < BLOCK; ++i)
            for (int m = 0; m < BLOCK; ++m)
                E[i][m] += term[i][m];
    }
}

static __attribute__((noinline)) Flow flow_over(const Plant *p, double sign, double h)
{
    Flow f;
    double A[BLOCK][BLOCK], b[BLOCK], x = -p->R / p->L * h, term = h, factorial[3] = {1, 2, 6};
    linear_part(p, sign, A, b);
    exponential(A, h, f.E);
    phi_series(A, b, h, f.phi);
    f.coil = exp(x);
    memset(f.coil_phi, 0, sizeof f.coil_phi);
    for (int j = 0; j < TERMS; ++j, term *= x)
        for (int k = 1; k <= 3; ++k) {
            f.coil_phi[k] += term / factorial[k - 1];
            factorial[k - 1] *= j + 1 + k;
        }
    return f;
}

typedef struct {
    double A, B, T; /* rates of the currents and the torque */
} Channels;

INLINE Channels nonlinear(const Plant *p, const State *at, const double *x, double s, double c)
{
    const double emf = p->k_m * x[OMEGA];
    const double T = p->k_m * (x[I_A] * s + x[I_B] * c) - detents(p, s, c) - at->sign * p->coulomb;
    return (Channels){(at->u[0] - emf * s) / p->L, (at->u[1] - emf * c) / p->L, T};
}

/* y = exp(h A) x */
INLINE void flown(const Flow *f, const double *x, double *y)
{
    double out[STATES] = {f->coil * x[I_A], f->coil * x[I_B]};
    for (int i = 0; i < BLOCK; ++i)
        for (int l = 0; l < BLOCK; ++l)
            out[2 + i] += f->E[i][l] * x[2 + l];
    memcpy(y, out, sizeof out);
}

/* y += h phi_k(h A) N */
INLINE void pushed(const Flow *f, int k, double weight, Channels N, double *y)
{
    y[I_A] += weight * f->coil_phi[k] * N.A;
    y[I_B] += weight * f->coil_phi[k] * N.B;
    for (int i = 0; i < BLOCK; ++i)
        y[2 + i] += weight * f->phi[k][i] * N.T;
}

INLINE Channels nonlinear_at(const Plant *p, const State *at, const double *x)
{
    double s, c;
    turned(p, at, x[ALPHA], &s, &c);
    return nonlinear(p, at, x, s, c);
}

INLINE Channels twice_less(Channels x, Channels y)
{
    return (Channels){2 * x.A - y.A, 2 * x.B - y.B, 2 * x.T - y.T};
}

/* Fourth-order exponential Runge-Kutta of Cox and Matthews (2002). */
INLINE void etdrk4(const Plant *p, State *at, const Flows *f)
{
    double from_half[STATES], a[STATES], b[STATES], c[STATES], end[STATES];
    const Channels N0 = nonlinear(p, at, at->x, at->s, at->c);
    flown(&f->half, at->x, from_half);
    memcpy(a, from_half, sizeof a);
    pushed(&f->half, 1, 1, N0, a);
    const Channels Na = nonlinear_at(p, at, a);
    memcpy(b, from_half, sizeof b);
    pushed(&f->half, 1, 1, Na, b);
    const Channels Nb = nonlinear_at(p, at, b);
    flown(&f->half, a, c);
    pushed(&f->half, 1, 1, twice_less(Nb, N0), c);
    const Channels Nc = nonlinear_at(p, at, c);
    const Channels Nab = {Na.A + Nb.A, Na.B + Nb.B, Na.T + Nb.T};
    flown(&f->whole, at->x, end);
    pushed(&f->whole, 1, 1, N0, end);
    pushed(&f->whole, 2, 1, (Channels){2 * Nab.A - 3 * N0.A - Nc.A, 2 * Nab.B - 3 * N0.B - Nc.B,
                                       2 * Nab.T - 3 * N0.T - Nc.T}, end);
    pushed(&f->whole, 3, 4, (Channels){N0.A + Nc.A - Nab.A, N0.B + Nc.B - Nab.B,
                                       N0.T + Nc.T - Nab.T}, end);
    turned(p, at, end[ALPHA], &at->s, &at->c);
    memcpy(at->x, end, sizeof end);
    at->evaluations += 4;
}

/* Half a step of the nonlinear channels alone, the angle held; midpoint rule. */
INLINE void kicked(const Plant *p, State *at, double h)
{
    const double moves = at->sign != 0 ? 1 / p->J_rot : 0;
    double x[STATES];
    memcpy(x, at->x, sizeof x);
    for (int pass = 0; pass < 2; ++pass) {
        const Channels N = nonlinear(p, at, x, at->s, at->c);
        const double tau = pass == 0 ? 0.5 * h : h, kick = tau * moves * N.T;
        memcpy(x, at->x, sizeof x);
        x[I_A] += tau * N.A;
        x[I_B] += tau * N.B;
        x[OMEGA] += kick;
        x[V] += kick;
        x[Z_DOT] += kick * p->J_rot * p->w0 * p->w0 * p->K_res;
    }
    memcpy(at->x, x, sizeof x);
}

INLINE void strang(const Plant *p, State *at, double h, const Flows *f)
{
    double end[STATES];
    kicked(p, at, 0.5 * h);
    flown(&f->whole, at->x, end);
    turned(p, at, end[ALPHA], &at->s, &at->c);
    memcpy(at->x, end, sizeof end);
    kicked(p, at, 0.5 * h);
    at->evaluations += 1; /* sine and cosine once a step */
}
