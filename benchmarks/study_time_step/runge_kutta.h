/* Explicit Runge-Kutta methods, on all states or with the housing mode in closed form. */

enum { PLAIN = STATES, CLOSED = Z }; /* states that the method carries */
enum { NO_FEED, PARABOLA, HERMITE, DENSE }; /* how T_res feeds the closed form: see derivatives() */

typedef struct {
    int stages;
    double a[12][12], b[12];
    double dense[13][4]; /* of the stages and the end, by powers 1 to 4 of the step's fraction */
} Tableau;

#include "tableaus.h" /* written by study_time_step.py */

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

/* T_res and its derivatives at the start of a step, as they feed the mode.
 *
 * PARABOLA: through T_res at the start, the middle and the end; the middle is the mean of RK4's two
 * middle stages, whose errors of second order cancel. HERMITE: the cubic with the value and the
 * rate of T_res at both ends; it asks nothing of the stages, so it serves every method.
 * DENSE: the rate of the method's own dense output for the integral of T_res, linear in the stages'
 * T_res; so their sensitivities feed those of the mode with the same weights, without second
 * derivatives.
 * x, s, c: state and angle of the step's end. */
INLINE void derivatives(
    const Plant *p, const State *at, double h, int feed, const Tableau *t, const double *T,
    const double *d_start, const double *x, double s, double c, double *q)
{
    double d[STATES];
    const double end = rates(p, at, CLOSED, x, s, c, d), jump = (end - T[0]) / h;
    q[0] = T[0];
    if (h < 1e-8) { /* the rounding of T_res, over powers of h, would outweigh what is left out */
        q[1] = jump;
        q[2] = q[3] = 0;
    } else if (feed == PARABOLA) {
        const double middle = 0.5 * (T[1] + T[2]);
        q[1] = (4 * middle - 3 * T[0] - end) / h;
        q[2] = 4 * (T[0] - 2 * middle + end) / (h * h);
        q[3] = 0;
    } else if (feed == DENSE) {
        const double scale[4] = {1, 2 / h, 6 / (h * h), 24 / (h * h * h)};
#pragma GCC unroll 4
        for (int k = 0; k < 4; ++k) {
            double sum = t->dense[t->stages][k] * end;
#pragma GCC unroll 12
            for (int j = 0; j < t->stages; ++j)
                sum += t->dense[j][k] * T[j];
            q[k] = scale[k] * sum;
        }
    } else {
        const double rate_end = T_res_rate(p, at->sign, x, s, c, d);
        q[1] = T_res_rate(p, at->sign, at->x, at->s, at->c, d_start);
        q[2] = 2 * (3 * jump - 2 * q[1] - rate_end) / h;
        q[3] = 6 * (q[1] + rate_end - 2 * jump) / (h * h);
    }
}

INLINE void runge_kutta(
    const Plant *p, State *at, double h, const Tableau *t, int n, int feed, const Mode *mode)
{
    double k[12][STATES], x[STATES], end[STATES], T[12], q[4], s = at->s, c = at->c;
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
        derivatives(p, at, h, feed, t, T, k[0], end, s, c, q);
        fed(p, mode, q, end);
    }
    memcpy(at->x, end, sizeof end);
    at->s = s;
    at->c = c;
    at->evaluations += t->stages;
}
