/* The sensitivity of every state to every parameter, along a Runge-Kutta step already made.
 *
 * Twelve parameters act on the drive train. They stand in three groups of four lanes, one AVX2
 * register each, sorted so that a group's right-hand side is mostly zero:
 *   0: R, L, k_m, T_frs   1: the two detents, Cartesian   2: T_frd, T_visc, K_s, D
 * The housing's own three parameters need no lane: z is proportional to K_res, and the closed form
 * is differentiated by w0 and zeta. */

enum { I_A, I_B, ALPHA, OMEGA, DELTA, V, STATES };
enum { GROUPS = 3, WIDTH = 4, COLUMNS = 16 };

typedef double Lane __attribute__((vector_size(WIDTH * sizeof(double))));

typedef struct {
    Lane x[STATES], a, b, z, z_dot;
} Group;

/* The linearised right-hand side at a point: its coefficients and, by group, its own terms. */
typedef struct {
    double A_omega, A_alpha, B_omega, B_alpha; /* of the currents' rates */
    double a_A, a_B, a_alpha, a_omega, a_b;    /* of the rotor's acceleration */
    Lane own_A, own_B, own_a[GROUPS], own_b;
} Tangent;

typedef struct {
    Group group[GROUPS];
    double w0_z, w0_v, zeta_z, zeta_v; /* of z and z' by w0 and zeta */
    Tangent here;
} Lanes;

static ALWAYS_INLINE Tangent tangent(const Plant *p, Mode m, Phases u, Point x)
{
    const double turning = p->is.half_poles * x.omega * p->k_per_L;
    const double c4 = 1 - 8 * x.m * x.m, s4 = 4 * x.m * x.c2;
    const double T_D_by_angle = 4 * (p->is.detent[0] * c4 - p->is.detent[1] * s4)
                              + 2 * p->is.detent[2] * x.c2 - 4 * p->is.detent[3] * x.m;
    const double T_by_angle = p->is.k_m * (x.i_A * x.c - x.i_B * x.s) - T_D_by_angle;
    const Phases di = current_rates(p, u, x);
    return (Tangent){
        .A_omega = -p->k_per_L * x.s, .A_alpha = -turning * x.c,
        .B_omega = -p->k_per_L * x.c, .B_alpha = turning * x.s,
        .a_A = p->is.k_m * m.per_J * x.s, .a_B = p->is.k_m * m.per_J * x.c,
        .a_alpha = p->is.half_poles * m.per_J * T_by_angle,
        .a_omega = -p->is.viscous * m.per_J, .a_b = -p->T_rg_per_b * m.per_J,
        .own_A = -p->per_L * (Lane){x.i_A, di.A, x.omega * x.s, 0},
        .own_B = -p->per_L * (Lane){x.i_B, di.B, x.omega * x.c, 0},
        .own_a = {m.per_J * (Lane){0, 0, x.i_A * x.s + x.i_B * x.c, 0},
                  -m.per_J * (Lane){s4, c4, 2 * x.m, x.c2},
                  -m.per_J * (Lane){m.sign, x.omega, 0, 0}},
        .own_b = p->per_J_m * (Lane){0, 0, x.delta, x.v}};
}

/* Sensitivity of the rotor's and the gear's acceleration, a and b of the group. */
static ALWAYS_INLINE void accelerate(const Plant *p, const Tangent *t, int q, Group *g)
{
    g->b = p->K_per_J_m * g->x[DELTA] + p->D_per_J_m * g->x[V];
    if (q == 2)
        g->b += t->own_b;
    g->a = ((t->own_a[q] + t->a_A * g->x[I_A]) + (t->a_B * g->x[I_B] + t->a_alpha * g->x[ALPHA]))
         + (t->a_omega * g->x[OMEGA] + t->a_b * g->b);
}

static ALWAYS_INLINE void rates(const Plant *p, const Tangent *t, int q, const Group *g, Lane *d)
{
    d[I_A] = t->A_omega * g->x[OMEGA] + t->A_alpha * g->x[ALPHA] - p->R_per_L * g->x[I_A];
    d[I_B] = t->B_omega * g->x[OMEGA] + t->B_alpha * g->x[ALPHA] - p->R_per_L * g->x[I_B];
    if (q == 0) {
        d[I_A] += t->own_A;
        d[I_B] += t->own_B;
    }
    d[ALPHA] = g->x[OMEGA];
    d[OMEGA] = g->a;
    d[DELTA] = g->x[V];
    d[V] = g->a - g->b;
}

/* Carry one group over the step; its a and b are those of the step's start, then of its end. */
static ALWAYS_INLINE void carry_group(
    const Plant *p, const Tangent *const *t, const Propagator *w, int q, Group *g)
{
    const double reach[4] = {0.5 * w->h, 0.5 * w->h, w->h, 0};
    const double weight[4] = {w->h * (1.0 / 6), w->h * (1.0 / 3), w->h * (1.0 / 3), w->h * (1.0 / 6)};
    const ModeStep *m = &w->value;
    const Lane start = g->a, z = g->z, v = g->z_dot;
    Group stage = *g, end = *g;
    Lane d[STATES], middle[4];
#pragma GCC unroll 4
    for (int j = 0; j < 4; ++j) {
        rates(p, t[j], q, &stage, d);
#pragma GCC unroll 6
        for (int i = 0; i < STATES; ++i) {
            end.x[i] += weight[j] * d[i];
            stage.x[i] = g->x[i] + reach[j] * d[i];
        }
        if (j < 3)
            accelerate(p, t[j + 1], q, &stage);
        middle[j] = stage.a;
    }
    accelerate(p, t[4], q, &end);
    const Lane mean = 0.5 * (middle[0] + middle[1]);
    end.z = (m->z_z * z + m->z_v * v) + (m->z_start * start + m->z_middle * mean) + m->z_end * end.a;
    end.z_dot = (m->v_z * z + m->v_v * v) + (m->v_start * start + m->v_middle * mean) + m->v_end * end.a;
    *g = end;
}

static ALWAYS_INLINE double applied(
    double z_z, double z_v, double start, double middle, double end, double z, double v,
    const double *a)
{
    return z_z * z + z_v * v + start * a[0] + middle * a[1] + end * a[2];
}

/* Carry the housing's own two parameters: the step's derivative on (z, z'), the step on theirs. */
static ALWAYS_INLINE void carry_mode(
    const ModeStep *m, const ModeStep *d, double z, double v, const double *a, double *S_z,
    double *S_v)
{
    const double none[3] = {0, 0, 0}, S = *S_z;
    *S_z = applied(d->z_z, d->z_v, d->z_start, d->z_middle, d->z_end, z, v, a)
         + applied(m->z_z, m->z_v, 0, 0, 0, S, *S_v, none);
    *S_v = applied(d->v_z, d->v_v, d->v_start, d->v_middle, d->v_end, z, v, a)
         + applied(m->v_z, m->v_v, 0, 0, 0, S, *S_v, none);
}
