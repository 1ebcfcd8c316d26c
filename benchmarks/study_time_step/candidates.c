/* The candidates of the time-step study, behind one time loop.
 *
 * Whatever the method, steps are split at every step edge, and a switch of the friction is located
 * by repeating the step; so the candidates differ in the step alone. */

#define _GNU_SOURCE
#include <math.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))

#include "plant.h"
#include "runge_kutta.h"
#include "linear_flow.h"

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

/* Positive while the friction's mode lasts, and its rate. */
typedef struct {
    double value, rate;
} Guard;

INLINE Guard guard(const Plant *p, const State *x)
{
    double d[STATES];
    const double T = rates(p, x, CLOSED, x->x, x->s, x->c, d);
    if (x->sign != 0)
        return (Guard){x->sign * x->x[OMEGA], x->sign * T / p->J_rot};
    const double tau = drive(p, x->x, x->s, x->c);
    const double rate = p->k_m * (d[I_A] * x->s + d[I_B] * x->c) - gear(p, d);
    return (Guard){p->static_ - fabs(tau), tau > 0 ? -rate : rate};
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

INLINE Guard guard_after(const Plant *p, Method m, State *x, double h)
{
    State trial = *x;
    stepped(p, m, &trial, h, 0);
    x->evaluations = trial.evaluations;
    return guard(p, &trial);
}

/* Where, within h, the guard is lowest; it falls at the start and rises at the end. */
static inline double lowest(const Plant *p, Method m, State *x, double h, Guard *g)
{
    double low = 0, high = h, middle = h;
    for (int i = 0; i < 60 && g->value >= 0; ++i) {
        middle = 0.5 * (low + high);
        *g = guard_after(p, m, x, middle);
        *(g->rate < 0 ? &low : &high) = middle;
    }
    return middle;
}

/* Where, within `high`, the guard goes through zero, `g_high` being its value there: the Illinois
 * method, and bisection while the rotor has only just broken away. */
static inline double located(const Plant *p, Method m, State *x, double high, double g_high)
{
    double low = 0, g_low = guard(p, x).value, last = -1, at = high;
    for (int i = 0, side = 0; i < 100; ++i) {
        at = g_low > 0 ? (low * g_high - high * g_low) / (g_high - g_low) : 0.5 * (low + high);
        const double g = guard_after(p, m, x, at).value;
        if (fabs(at - last) < 1e-14 * high || g == 0)
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

/* Advance by h through whatever switches lie in it. Also one that ends within the step is found:
 * where the guard's tangents at both ends reach zero, its lowest point is looked up. */
INLINE void advanced(const Plant *p, Method m, State *x, double h, const Regular *regular)
{
    for (int i = 0; i < 50 && h > 1e-13; ++i) {
        State end = *x;
        stepped(p, m, &end, h, i == 0 ? regular : 0);
        const Guard before = guard(p, x);
        Guard g = guard(p, &end);
        double high = h;
        x->evaluations = end.evaluations;
        if (__builtin_expect(before.value + h * before.rate < 0 && g.value - h * g.rate < 0, 0))
            high = lowest(p, m, x, h, &g);
        if (__builtin_expect(g.value >= 0, 1)) {
            end.evaluations = x->evaluations;
            *x = end;
            return;
        }
        const double part = located(p, m, x, high, g.value);
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
    if (guard(p, x).value < 0) {
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
CANDIDATE(dp5_dense, RUNGE_KUTTA, &DP5, CLOSED, DENSE)
CANDIDATE(tsit5_hermite, RUNGE_KUTTA, &TSIT5, CLOSED, HERMITE)
CANDIDATE(rk6_plain, RUNGE_KUTTA, &RK6, PLAIN, NO_FEED)
CANDIDATE(rk6_hermite, RUNGE_KUTTA, &RK6, CLOSED, HERMITE)
CANDIDATE(dop8_plain, RUNGE_KUTTA, &DOP8, PLAIN, NO_FEED)
CANDIDATE(dop8_hermite, RUNGE_KUTTA, &DOP8, CLOSED, HERMITE)
CANDIDATE(etdrk4_linear, ETDRK4, 0, PLAIN, NO_FEED)
CANDIDATE(strang_linear, STRANG, 0, PLAIN, NO_FEED)
