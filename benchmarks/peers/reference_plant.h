/* The drive train: six states, set-valued friction, one Runge-Kutta step.
 *
 * States: i_A, i_B, alpha, omega and the wind-up of the gear delta = alpha - G alpha_g, v = delta'.
 * With b = G^2 T_rg / J_m = (K_s delta + D v) / J_m and a = T_res / J_rot:
 * omega' = a, v' = a - b. */

typedef struct { /* as the caller lays them out: problem.PARAMETERS, then the constants */
    double R, L, k_m, static_, detent[4], coulomb, viscous, K_s, D, K_res, w0, zeta;
    double half_poles, J_rot, G, J_m;
} Values;

typedef struct { /* the values and what the loop would divide for at every step */
    Values is;
    double per_L, R_per_L, k_per_L, per_J, per_J_m, K_per_J_m, D_per_J_m;
    double T_rg_per_b, y_per_b; /* T_rg / b and T_applied / b */
    double m_c2, m_1, c2_1, mm_1; /* T_D by products of m = sin cos and c2: see completed() */
} Plant;

static Plant prepared(const Values *x)
{
    return (Plant){
        .is = *x, .per_L = 1 / x->L, .R_per_L = x->R / x->L, .k_per_L = x->k_m / x->L,
        .per_J = 1 / x->J_rot, .per_J_m = 1 / x->J_m, .K_per_J_m = x->K_s / x->J_m,
        .D_per_J_m = x->D / x->J_m, .T_rg_per_b = x->J_m / (x->G * x->G), .y_per_b = x->J_m / x->G,
        .m_c2 = 4 * x->detent[0], .m_1 = 2 * x->detent[2], .c2_1 = x->detent[3],
        .mm_1 = -8 * x->detent[1]};
}

typedef struct {
    double sign;    /* of the rotor's speed; 0 while it sticks */
    double per_J;   /* 1 / J_rot, and 0 while it sticks */
    double coulomb; /* T_frd sign */
} Mode;

typedef struct {
    double A, B;
} Phases;

typedef struct {
    double i_A, i_B, alpha, omega, delta, v; /* the state */
    double s, c, m, c2;                      /* of the electrical angle p/2 alpha; m = s c */
    double tau, a, b;                        /* tau = T_mot - T_rg */
} Point;

typedef struct {
    Point first, second, third, fourth, end;
} Step;

/* Complete a point from its state and the sine and cosine of its electrical angle.
 *
 * Both detents are written in m = s c and c2 = 1 - 2 s^2, as sin 2x = 2 m, sin 4x = 4 m c2 and
 * cos 4x = 1 - 8 m^2: the shortest chain of operations, and the loop is bound by latency. */
static ALWAYS_INLINE Point completed(const Plant *p, Mode m, Point x)
{
    x.m = x.s * x.c;
    x.c2 = 1 - 2 * x.s * x.s;
    x.b = p->K_per_J_m * x.delta + p->D_per_J_m * x.v;
    const double T_D_even = p->c2_1 * x.c2 + (p->is.detent[1] + p->mm_1 * (x.m * x.m));
    const double T_D_odd = x.m * (p->m_1 + p->m_c2 * x.c2);
    const double T_AB = p->is.k_m * (x.i_A * x.s + x.i_B * x.c);
    x.tau = ((T_AB - p->T_rg_per_b * x.b) - T_D_even) - T_D_odd;
    x.a = m.per_J * (x.tau - (m.coulomb + p->is.viscous * x.omega));
    return x;
}

static __attribute__((noinline)) Phases sine_cosine(double angle)
{
    Phases of;
    sincos(angle, &of.A, &of.B);
    return of;
}

static ALWAYS_INLINE Point looked_up(const Plant *p, Mode m, Point x)
{
    const Phases of = sine_cosine(p->is.half_poles * x.alpha);
    x.s = of.A;
    x.c = of.B;
    return completed(p, m, x);
}

/* Complete a point whose electrical angle is that of `from` and `e` more. */
static ALWAYS_INLINE Point turned(const Plant *p, Mode m, Point x, Point from, double e)
{
    if (__builtin_expect(fabs(e) > 0.1, 0))
        return looked_up(p, m, x);
    const double q = e * e, qq = q * q;
    const double sine = ((-1.0 / 6) + q * (1.0 / 120)) - qq * (1.0 / 5040); /* (sin e - e) / e^3 */
    const double versine = (0.5 - q * (1.0 / 24)) + qq * ((1.0 / 720) - q * (1.0 / 40320));
    x.s = ((from.s + from.c * e) + (from.c * e * q) * sine) - (from.s * q) * versine;
    x.c = ((from.c - from.s * e) - (from.s * e * q) * sine) - (from.c * q) * versine;
    return completed(p, m, x);
}

static ALWAYS_INLINE Phases current_rates(const Plant *p, Phases u, Point x)
{
    const double emf = p->k_per_L * x.omega;
    return (Phases){(p->per_L * u.A - p->R_per_L * x.i_A) - emf * x.s,
                    (p->per_L * u.B - p->R_per_L * x.i_B) - emf * x.c};
}

/* The point `h` after `from` along the rates of `at`. */
static ALWAYS_INLINE Point moved(
    const Plant *p, Mode m, Phases u, Point from, Point at, double h)
{
    const Phases di = current_rates(p, u, at);
    const double turn = h * at.omega;
    const Point x = {.i_A = from.i_A + h * di.A, .i_B = from.i_B + h * di.B,
                     .alpha = from.alpha + turn, .omega = from.omega + h * at.a,
                     .delta = from.delta + h * at.v, .v = from.v + h * (at.a - at.b)};
    return turned(p, m, x, from, p->is.half_poles * turn);
}

static ALWAYS_INLINE double weighed(double h, double a, double b, double c, double d)
{
    return (h / 6) * ((a + d) + 2 * (b + c));
}

/* One classical Runge-Kutta step; its end point is the first stage of the next. */
static ALWAYS_INLINE Step runge_kutta(const Plant *p, Mode m, Phases u, Point x, double h)
{
    const Point b = moved(p, m, u, x, x, 0.5 * h), c = moved(p, m, u, x, b, 0.5 * h);
    const Point d = moved(p, m, u, x, c, h);
    const Phases i1 = current_rates(p, u, x), i2 = current_rates(p, u, b);
    const Phases i3 = current_rates(p, u, c), i4 = current_rates(p, u, d);
    const double turn = weighed(h, x.omega, b.omega, c.omega, d.omega);
    const double d_omega = weighed(h, x.a, b.a, c.a, d.a);
    const Point end = {
        .i_A = x.i_A + weighed(h, i1.A, i2.A, i3.A, i4.A),
        .i_B = x.i_B + weighed(h, i1.B, i2.B, i3.B, i4.B),
        .alpha = x.alpha + turn,
        .omega = x.omega + d_omega,
        .delta = x.delta + weighed(h, x.v, b.v, c.v, d.v),
        .v = x.v + (d_omega - weighed(h, x.b, b.b, c.b, d.b))};
    return (Step){x, b, c, d, turned(p, m, end, x, p->is.half_poles * turn)};
}

/* Positive while the friction's mode lasts: the speed's distance from zero while the rotor moves,
 * the torque's from static friction while it sticks. */
typedef struct {
    double value, rate;
} Guard;

static ALWAYS_INLINE Guard guard(const Plant *p, Mode m, Phases u, Point x)
{
    if (__builtin_expect(m.sign != 0, 1))
        return (Guard){m.sign * x.omega, m.sign * x.a};
    const Phases di = current_rates(p, u, x);
    const double b_rate = p->K_per_J_m * x.v - p->D_per_J_m * x.b;
    const double rate = p->is.k_m * (di.A * x.s + di.B * x.c) - p->T_rg_per_b * b_rate;
    return (Guard){p->is.static_ - fabs(x.tau), x.tau > 0 ? -rate : rate};
}

/* Whether a switch may lie in a step of h: the guard ends below zero, or it may have been there and
 * come back, for its tangents at both ends reach zero within the step. */
static ALWAYS_INLINE int may_switch(Guard start, Guard end, double h)
{
    return end.value < 0
        || (start.value + h * start.rate < 0 && end.value - h * end.rate < 0);
}

/* The length after which the mode ends, to rounding, or h where it lasts. The slow path: bisection,
 * first for the guard's lowest point where its end is above zero, then for its zero. */
static __attribute__((noinline)) double lasting(const Plant *p, Mode m, Phases u, Point x, double h)
{
    double low = 0, high = h;
    Guard g = guard(p, m, u, runge_kutta(p, m, u, x, h).end);
    for (int i = 0; i < 60 && g.value >= 0; ++i) {
        const double middle = 0.5 * (low + high);
        g = guard(p, m, u, runge_kutta(p, m, u, x, middle).end);
        *(g.rate < 0 && g.value >= 0 ? &low : &high) = middle;
    }
    if (g.value >= 0)
        return h;
    low = 0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        g = guard(p, m, u, runge_kutta(p, m, u, x, middle).end);
        *(g.value >= 0 ? &low : &high) = middle;
    }
    return high;
}

/* The mode of a rotor at rest in x: breaking away, or held where static friction suffices. */
static ALWAYS_INLINE Mode breaking_away(const Plant *p, Point x)
{
    const double sign = copysign(1, x.tau);
    return (Mode){sign, p->per_J, sign * p->is.coulomb};
}

static ALWAYS_INLINE Mode at_rest(const Plant *p, Point x)
{
    return fabs(x.tau) > p->is.static_ ? breaking_away(p, x) : (Mode){0, 0, 0};
}
