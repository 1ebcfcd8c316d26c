/* The sweep by hand: what a plain C loop can do, as the limit for the other peers.
 *
 * Runge-Kutta on six states, split at every step edge; the housing mode in closed form, fed by the
 * stages' torques; friction set-valued, every switch located to rounding; sensitivities carried
 * along with their jumps at the switches. Equations: Kornienko et al. (2013), housing form "paper".
 * reference_plant.h holds the drive train, reference_housing.h the mode, reference_lanes.h the
 * sensitivities; this file the time loop, the switches and the outputs. */

#define _GNU_SOURCE
#include <math.h>
#include <string.h>

#define ALWAYS_INLINE inline __attribute__((always_inline))

#include "reference_plant.h"
#include "reference_housing.h"
#include "reference_lanes.h"

enum { OK = 0, CHATTERS = 1, DIVERGED = 2 };
enum { MAX_SWITCHES = 50, REFRESH = 256 };
static const double INSTANT = 1e-13; /* s; shorter steps are not made */

typedef struct {
    Point here;
    double z, z_dot;
    Mode mode;
    Phases u;
    long switches;
    int status;
} State;

/* Carry the sensitivities over a step. Not inlined: mixed into the state's step they would drive
 * each other out of the registers. `was` is the start's z, z'; a is T_res / J_rot at three points. */
static __attribute__((noinline)) void carry(
    const Plant *p, const Tangent *inner, const Propagator *w, Phases was, const double *a,
    Lanes *lanes)
{
    const Tangent *const t[5] = {&lanes->here, inner, inner + 1, inner + 2, inner + 3};
#pragma GCC unroll 3
    for (int q = 0; q < GROUPS; ++q)
        carry_group(p, t, w, q, &lanes->group[q]);
    carry_mode(&w->value, &w->by_w0, was.A, was.B, a, &lanes->w0_z, &lanes->w0_v);
    carry_mode(&w->value, &w->by_zeta, was.A, was.B, a, &lanes->zeta_z, &lanes->zeta_v);
    lanes->here = inner[3];
}

/* Carry the state, and with it the sensitivities, over a Runge-Kutta step. */
static ALWAYS_INLINE void take(
    const Plant *p, State *x, Lanes *lanes, const Step *r, const Propagator *w)
{
    const ModeStep *m = &w->value;
    const double a[3] = {r->first.a, 0.5 * (r->second.a + r->third.a), r->end.a};
    const Phases was = {x->z, x->z_dot};
    x->z = applied(m->z_z, m->z_v, m->z_start, m->z_middle, m->z_end, was.A, was.B, a);
    x->z_dot = applied(m->v_z, m->v_v, m->v_start, m->v_middle, m->v_end, was.A, was.B, a);
    x->here = r->end;
    if (lanes) {
        const Mode n = x->mode;
        const Tangent inner[4] = {tangent(p, n, x->u, r->second), tangent(p, n, x->u, r->third),
                                  tangent(p, n, x->u, r->fourth), tangent(p, n, x->u, r->end)};
        carry(p, inner, w, was, a, lanes);
    }
}

/* The tangent and every group's a and b here, after the voltages, the mode or S changed. */
static void refresh(const Plant *p, const State *x, Lanes *lanes)
{
    const Tangent *t = &lanes->here;
    lanes->here = tangent(p, x->mode, x->u, x->here);
    accelerate(p, t, 0, &lanes->group[0]);
    accelerate(p, t, 1, &lanes->group[1]);
    accelerate(p, t, 2, &lanes->group[2]);
}

/* Cut off the tails of sensitivities that die out between switches, as that to static friction does:
 * numbers below the normal range would slow the lanes down by a seventh. */
static void cut_tails(Lanes *lanes)
{
    for (int q = 0; q < GROUPS; ++q) {
        double *x = (double *)&lanes->group[q];
        for (size_t i = 0; i < sizeof lanes->group[q] / sizeof *x; ++i)
            x[i] = fabs(x[i]) < 1e-200 ? 0 : x[i];
    }
}

/* d(instant)/dp = -(g_x S + g_p) / (g_x f + g_t) of one group at a switch. */
static Lane instant(const Plant *p, const State *before, int q, const Group *g)
{
    if (before->mode.sign != 0) /* guard: omega */
        return -g->x[OMEGA] / before->here.a;
    const Point y = before->here; /* guard: |tau| - T_frs */
    const Tangent t = tangent(p, (Mode){0, p->per_J, 0}, before->u, y);
    const Phases di = current_rates(p, before->u, y);
    const double b_dot = p->K_per_J_m * y.v - p->D_per_J_m * y.b;
    const double tau_dot = p->is.J_rot * (t.a_A * di.A + t.a_B * di.B + t.a_b * b_dot);
    Group probe = *g;
    accelerate(p, &t, q, &probe);
    Lane g_p = {0, 0, 0, 0};
    if (q == 0)
        g_p[3] = copysign(1, y.tau);
    return -(p->is.J_rot * probe.a - g_p) / tau_dot;
}

/* S+ = S- + (f- - f+) d(instant)/dp; only omega', v' and the housing's z'' jump, by that of a. */
static void jumped(const Plant *p, const State *before, const State *after, Lanes *lanes)
{
    const double fall = before->here.a - after->here.a;
    const double force = p->is.K_res * p->is.w0 * p->is.w0 * p->is.J_rot;
    for (int q = 0; q < GROUPS; ++q) {
        Group *g = &lanes->group[q];
        const Lane d = fall * instant(p, before, q, g);
        g->x[OMEGA] += d;
        g->x[V] += d;
        g->z_dot += force * d;
    }
}

static State switched_over(const Plant *p, State before, Lanes *lanes)
{
    State after = before;
    after.here.omega = 0;
    after.mode = before.mode.sign != 0 ? at_rest(p, after.here) : breaking_away(p, after.here);
    after.here = looked_up(p, after.mode, after.here);
    after.switches += 1;
    if (lanes) {
        jumped(p, &before, &after, lanes);
        refresh(p, &after, lanes);
    }
    return after;
}

/* Advance by `length` through the switches that lie in it; a slow path, taken for one step in
 * thousands. */
static __attribute__((noinline)) State through_switches(
    const Plant *p, State x, Lanes *lanes, double length)
{
    double left = length;
    for (int i = 0; i < MAX_SWITCHES && left > INSTANT; ++i) {
        const double h = lasting(p, x.mode, x.u, x.here, left);
        const Step r = runge_kutta(p, x.mode, x.u, x.here, h);
        const Propagator part = propagator(&p->is, h, lanes != 0);
        take(p, &x, lanes, &r, &part);
        if (h == left)
            return x;
        x = switched_over(p, x, lanes);
        left -= h;
    }
    x.status = left > INSTANT ? CHATTERS : OK;
    return x;
}

/* Advance by the length of `step`. Here and above the slow path takes and returns the state by
 * value: its address never leaves the loop, so that the loop keeps it in registers. */
static ALWAYS_INLINE void advance(const Plant *p, State *x, Lanes *lanes, const Propagator *step)
{
    const Step r = runge_kutta(p, x->mode, x->u, x->here, step->h);
    const Guard start = guard(p, x->mode, x->u, r.first), end = guard(p, x->mode, x->u, r.end);
    if (__builtin_expect(may_switch(start, end, step->h), 0))
        *x = through_switches(p, *x, lanes, step->h);
    else
        take(p, x, lanes, &r, step);
}

/* The record's start: at rest, currents settled, rotor as commanded, gear unwound. */
static State started(const Plant *p, Phases u, double start_angle, Lanes *lanes)
{
    State x = {.u = u, .mode = {0, 0, 0}};
    x.here.i_A = u.A / p->is.R;
    x.here.i_B = u.B / p->is.R;
    x.here.alpha = start_angle / p->is.half_poles;
    x.here = looked_up(p, x.mode, x.here);
    x.mode = at_rest(p, x.here);
    x.here = looked_up(p, x.mode, x.here);
    if (lanes) {
        memset(lanes, 0, sizeof *lanes);
        lanes->group[0].x[I_A][0] = -x.here.i_A / p->is.R;
        lanes->group[0].x[I_B][0] = -x.here.i_B / p->is.R;
        refresh(p, &x, lanes);
    }
    return x;
}

/* One row of the Jacobian of y; its last column is -dy/dt, for the record's time offset. */
static ALWAYS_INLINE void write_row(const Plant *p, const State *x, const Lanes *lanes, double *row)
{
    const Point y = x->here;
    const double b_dot = p->K_per_J_m * y.v + p->D_per_J_m * (y.a - y.b);
    const Lane last = {-x->z / p->is.K_res, -lanes->w0_z, -lanes->zeta_z, x->z_dot + p->y_per_b * b_dot};
    for (int q = 0; q < GROUPS; ++q) {
        const Lane J = -(lanes->group[q].z + p->y_per_b * lanes->group[q].b);
        memcpy(row + q * WIDTH, &J, sizeof J);
    }
    memcpy(row + GROUPS * WIDTH, &last, sizeof last);
}

typedef struct {
    double start_angle, sample_time;
    long n_samples, n_substeps, n_edges;
    const double *edge_times; /* ascending */
    const double *voltages;   /* u_A, u_B before the first edge and after each */
} Command;

typedef struct {
    double *torque;   /* one value a sample */
    double *jacobian; /* `rows` rows of 16, written over and over */
    long rows;
    double *final;    /* i_A, i_B, alpha, omega, alpha_g, omega_g, z, z', mode, number of switches */
} Output;

static void write_final(const Plant *p, const State *x, double *final)
{
    const Point y = x->here;
    const double values[10] = {y.i_A, y.i_B, y.alpha, y.omega, (y.alpha - y.delta) / p->is.G,
                               (y.omega - y.v) / p->is.G, x->z, x->z_dot,
                               x->mode.sign, (double)x->switches};
    memcpy(final, values, sizeof values);
}

/* Cross one sampling interval; `edge` counts the step edges passed. Each piece between the ends of
 * the substeps and the edges is one step. */
static ALWAYS_INLINE void cross(
    const Plant *p, const Command *c, double start, const Propagator *regular, State *x,
    Lanes *lanes, long *edge)
{
    const double *next = c->edge_times + *edge;
    double from = 0;
    for (long j = 1; j <= c->n_substeps;) {
        const double end = j * regular->h;
        const int at_edge = *edge < c->n_edges && *next - start < end - INSTANT;
        const double to = at_edge ? *next - start : end;
        if (!at_edge && from == (j - 1) * regular->h)
            advance(p, x, lanes, regular);
        else if (to - from > INSTANT) {
            const Propagator part = propagator(&p->is, to - from, lanes != 0);
            advance(p, x, lanes, &part);
        }
        from = to;
        if (at_edge) {
            const double *u = c->voltages + 2 * ++*edge;
            x->u = (Phases){u[0], u[1]};
            if (lanes)
                lanes->here = tangent(p, x->mode, x->u, x->here);
            ++next;
        } else
            ++j;
    }
}

static ALWAYS_INLINE int simulated(
    const Values *values, const Command *command, const Output *out, Lanes *lanes)
{
    const Plant plant = prepared(values), *p = &plant;
    const Command c = *command;
    const Propagator regular = propagator(values, c.sample_time / c.n_substeps, lanes != 0);
    State x = started(p, (Phases){c.voltages[0], c.voltages[1]}, c.start_angle, lanes);
    long edge = 0, row = 0;
    for (long i = 0; i < c.n_samples && x.status == OK; ++i) {
        out->torque[i] = -(x.z + p->y_per_b * x.here.b);
        if (lanes) {
            write_row(p, &x, lanes, out->jacobian + COLUMNS * row);
            row = row + 1 == out->rows ? 0 : row + 1;
        }
        if (i % REFRESH == 0) {
            x.here = looked_up(p, x.mode, x.here);
            if (lanes)
                cut_tails(lanes);
        }
        if (i + 1 < c.n_samples)
            cross(p, &c, i * c.sample_time, &regular, &x, lanes, &edge);
    }
    write_final(p, &x, out->final);
    return x.status == OK && !isfinite(x.z) ? DIVERGED : x.status;
}

int simulate(const Values *values, const Command *command, const Output *output)
{
    return simulated(values, command, output, 0);
}

int simulate_with_jacobian(const Values *values, const Command *command, const Output *output)
{
    Lanes lanes;
    return simulated(values, command, output, &lanes);
}
