/* The candidates of the time-step study, behind one time loop.
 *
 * State: i_A, i_B, alpha, omega, delta = alpha - G alpha_g, v = delta', z, z'. Whatever the method,
 * steps are split at every step edge, and a switch of the friction is located by repeating the
 * step; so the candidates differ in the step alone. study_time_step.py compiles this file together
 * with tableaus.h, which it writes, and explains the candidates. */

#define _GNU_SOURCE
#include <math.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))

enum { I_A, I_B, ALPHA, OMEGA, DELTA, V, Z, Z_DOT, STATES };
enum { PLAIN = STATES, CLOSED = Z }; /* states that the Runge-Kutta method carries */
enum { NO_FEED, PARABOLA, HERMITE };

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

typedef struct {
    int stages;
    double a[12][12], b[12];
} Tableau;

#include "tableaus.h"

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
    *s = x->s + (x->c * sine - x->s * versine);
    *c = x->c - (x->s * sine + x->c * versine);
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
    if (n == PLAIN) {
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

/* ---- the housing mode in closed form, fed by T_res as a cubic in time ---- */

typedef struct {
    double c, c_dot, I[4]; /* answer to a unit impulse, its rate, its repeated integrals */
} Mode;

INLINE Mode mode_over(const Plant *p, double h)
{
    const double b = p->w0 * p->w0, a = 2 * p->zeta * p->w0;
    const double wd = p->w0 * sqrt(1 - p->zeta * p->zeta), decay = exp(-0.5 * a * h);
    double sine, cosine;
    sincos(wd * h, &sine, &cosine);
    Mode m = {.c = decay * sine / wd};
    m.c_dot = decay * cosine - 0.5 * a * m.c;
    m.I[0] = (1 - m.c_dot - a * m.c) / b;
    m.I[1] = (h - m.c - a * m.I[0]) / b;
    m.I[2] = (h * h / 2 - m.I[0] - a * m.I[1]) / b;
    m.I[3] = (h * h * h / 6 - m.I[1] - a * m.I[2]) / b;
    return m;
}

/* q: value and derivatives of T_res at the step's start. */
INLINE void fed(const Plant *p, const Mode *m, const double *q, double *x)
{
    const double b = p->w0 * p->w0, a = 2 * p->zeta * p->w0, z = x[Z], v = x[Z_DOT];
    const double f = b * p->K_res;
    x[Z] = (m->c_dot + a * m->c) * z + m->c * v
         + f * (q[0] * m->I[0] + q[1] * m->I[1] + q[2] * m->I[2] + q[3] * m->I[3]);
    x[Z_DOT] = -b * m->c * z + m->c_dot * v
         + f * (q[0] * m->c + q[1] * m->I[0] + q[2] * m->I[1] + q[3] * m->I[2]);
}

/* ---- explicit Runge-Kutta, plain or with the closed form ---- */

INLINE void runge_kutta(
    const Plant *p, State *at, double h, const Tableau *t, int n, int feed, const Mode *mode)
{
    double k[12][STATES], x[STATES], end[STATES], T[12], s = at->s, c = at->c;
    memcpy(end, at->x, sizeof end);
#pragma GCC unroll 12
    for (int j = 0; j < t->stages; ++j) {
        memcpy(x, at->x, sizeof x);
#pragma GCC unroll 12
        for (int l = 0; l < j; ++l)
#pragma GCC unroll 8
            for (int i = 0; i < n; ++i)
                x[i] += h * t->a[j][l] * k[l][i];
        if (j > 0)
            turned(p, at, x[ALPHA], &s, &c);
        T[j] = rates(p, at, n, x, s, c, k[j]);
#pragma GCC unroll 8
        for (int i = 0; i < n; ++i)
            end[i] += h * t->b[j] * k[j][i];
    }
    turned(p, at, end[ALPHA], &s, &c);
    if (feed != NO_FEED) {
        double d[STATES], T1 = rates(p, at, CLOSED, end, s, c, d), q[4] = {T[0], 0, 0, 0};
        if (feed == PARABOLA) {
            const double middle = 0.5 * (T[1] + T[2]);
            q[1] = (4 * middle - 3 * T[0] - T1) / h;
            q[2] = 4 * (T[0] - 2 * middle + T1) / (h * h);
        } else {
            const double r = 1 / h, jump = (T1 - T[0]) * r;
            const double d0 = T_res_rate(p, at->sign, at->x, at->s, at->c, k[0]);
            const double d1 = T_res_rate(p, at->sign, end, s, c, d);
            q[1] = d0;
            q[2] = 2 * r * (3 * jump - 2 * d0 - d1);
            q[3] = 6 * r * r * (d0 + d1 - 2 * jump);
        }
        fed(p, mode, q, end);
    }
    memcpy(at->x, end, sizeof end);
    at->s = s;
    at->c = c;
    at->evaluations += t->stages;
}

#include "study_linear_flow.h"

/* ---- one step of any method, and the time loop ---- */

enum { RUNGE_KUTTA, ETDRK4, STRANG };

typedef struct { /* constant where it is used: the compiler writes one loop for each */
    int kind;
    const Tableau *tableau;
    int states, feed;
} Method;

typedef struct {
    double h;
    Mode mode;
    Flows moving, stuck;
} Regular;

INLINE Flows flows_over(const Plant *p, Method m, double sign, double h)
{
    Flows f = {.whole = flow_over(p, sign, h)};
    if (m.kind == ETDRK4)
        f.half = flow_over(p, sign, 0.5 * h);
    return f;
}

/* Step by h; `regular` holds what was computed beforehand for a step of its own length, else null. */
INLINE void stepped(const Plant *p, Method m, State *x, double h, const Regular *regular)
{
    if (m.kind == RUNGE_KUTTA) {
        Mode mode;
        if (m.feed != NO_FEED)
            mode = regular ? regular->mode : mode_over(p, h);
        runge_kutta(p, x, h, m.tableau, m.states, m.feed, &mode);
        return;
    }
    Flows own;
    const Flows *f = &own;
    if (regular)
        f = x->sign != 0 ? &regular->moving : &regular->stuck;
    else
        own = flows_over(p, m, x->sign, h);
    if (m.kind == ETDRK4)
        etdrk4(p, x, f);
    else
        strang(p, x, h, f);
}

/* Positive while the friction's mode lasts. */
INLINE double guard(const Plant *p, const State *x)
{
    if (x->sign != 0)
        return x->sign * x->x[OMEGA];
    return p->static_ - fabs(drive(p, x->x, x->s, x->c));
}

INLINE void switch_over(const Plant *p, State *x)
{
    sincos(p->half_poles * x->x[ALPHA], &x->s, &x->c);
    const double tau = drive(p, x->x, x->s, x->c);
    const int holds = x->sign != 0 && fabs(tau) <= p->static_;
    x->x[OMEGA] = 0;
    x->sign = holds ? 0 : copysign(1, tau);
    x->switches += 1;
}

/* The distance of the switch that a step of h from x crosses, `g_high` being the guard there: the
 * Illinois method, and bisection while the rotor has only just broken away. */
static inline double located(const Plant *p, Method m, State *x, double h, double g_high)
{
    double low = 0, high = h, g_low = guard(p, x), last = -1, at = h;
    for (int i = 0, side = 0; i < 100; ++i) {
        at = g_low > 0 ? (low * g_high - high * g_low) / (g_high - g_low) : 0.5 * (low + high);
        State trial = *x;
        stepped(p, m, &trial, at, 0);
        x->evaluations = trial.evaluations;
        const double g = guard(p, &trial);
        if (fabs(at - last) < 1e-14 * h || g == 0)
            break;
        last = at;
        if (g < 0) {
            high = at, g_high = g;
            g_low *= side < 0 ? 0.5 : 1;
            side = -1;
        } else {
            low = at, g_low = g;
            g_high *= side > 0 ? 0.5 : 1;
            side = 1;
        }
    }
    return at;
}

/* Advance by h through whatever switches lie in it. */
INLINE void advanced(const Plant *p, Method m, State *x, double h, const Regular *regular)
{
    for (int i = 0; i < 50 && h > 1e-13; ++i) {
        State end = *x;
        stepped(p, m, &end, h, i == 0 ? regular : 0);
        const double g = guard(p, &end);
        x->evaluations = end.evaluations;
        if (__builtin_expect(g >= 0, 1)) {
            *x = end;
            return;
        }
        const double part = located(p, m, x, h, g);
        stepped(p, m, x, part, 0);
        switch_over(p, x);
        h -= part;
    }
}

typedef struct {
    double start_angle, sample_time;
    long n_samples, n_substeps, n_edges;
    const double *edge_times, *voltages;
} Command;

INLINE void started(const Plant *p, const Command *c, State *x)
{
    memset(x, 0, sizeof *x);
    memcpy(x->u, c->voltages, sizeof x->u);
    x->x[I_A] = x->u[0] / p->R;
    x->x[I_B] = x->u[1] / p->R;
    x->x[ALPHA] = c->start_angle / p->half_poles;
    sincos(c->start_angle, &x->s, &x->c);
    if (guard(p, x) < 0) {
        switch_over(p, x);
        x->switches = 0;
    }
}

/* Simulate; counts: switches, evaluations of the right-hand side. */
INLINE void simulated(const Plant *p, const Command *c, Method m, double *torque, long *counts)
{
    const double h = c->sample_time / c->n_substeps;
    Regular regular = {.h = h, .mode = mode_over(p, h)};
    if (m.kind != RUNGE_KUTTA) {
        regular.moving = flows_over(p, m, 1, h);
        regular.stuck = flows_over(p, m, 0, h);
    }
    State x;
    started(p, c, &x);
    long edge = 0;
    for (long i = 0; i < c->n_samples; ++i) {
        torque[i] = -(x.x[Z] + p->G * gear(p, x.x));
        if (i % 256 == 0)
            sincos(p->half_poles * x.x[ALPHA], &x.s, &x.c);
        if (i + 1 == c->n_samples)
            break;
        const double start = i * c->sample_time;
        double from = 0;
        for (long j = 1; j <= c->n_substeps; ++j) {
            const double to = j * h;
            for (; edge < c->n_edges && c->edge_times[edge] - start < to - 1e-13; ++edge) {
                const double at = c->edge_times[edge] - start;
                if (at > from) {
                    advanced(p, m, &x, at - from, 0);
                    from = at;
                }
                memcpy(x.u, c->voltages + 2 * (edge + 1), sizeof x.u);
            }
            advanced(p, m, &x, to - from, from == (j - 1) * h ? &regular : 0);
            from = to;
        }
    }
    counts[0] = x.switches;
    counts[1] = x.evaluations;
}

#define CANDIDATE(NAME, ...)                                                                       \
    void NAME(const Plant *p, const Command *c, double *torque, long *counts)                      \
    {                                                                                              \
        simulated(p, c, (Method){__VA_ARGS__}, torque, counts);                                    \
    }

CANDIDATE(rk4_plain, RUNGE_KUTTA, &RK4, PLAIN, NO_FEED)
CANDIDATE(rk4_parabola, RUNGE_KUTTA, &RK4, CLOSED, PARABOLA)
CANDIDATE(rk4_hermite, RUNGE_KUTTA, &RK4, CLOSED, HERMITE)
CANDIDATE(dp5_plain, RUNGE_KUTTA, &DP5, PLAIN, NO_FEED)
CANDIDATE(dp5_hermite, RUNGE_KUTTA, &DP5, CLOSED, HERMITE)
CANDIDATE(rk6_plain, RUNGE_KUTTA, &RK6, PLAIN, NO_FEED)
CANDIDATE(rk6_hermite, RUNGE_KUTTA, &RK6, CLOSED, HERMITE)
CANDIDATE(dop8_plain, RUNGE_KUTTA, &DOP8, PLAIN, NO_FEED)
CANDIDATE(dop8_hermite, RUNGE_KUTTA, &DOP8, CLOSED, HERMITE)
CANDIDATE(etdrk4_linear, ETDRK4, 0, PLAIN, NO_FEED)
CANDIDATE(strang_linear, STRANG, 0, PLAIN, NO_FEED)
