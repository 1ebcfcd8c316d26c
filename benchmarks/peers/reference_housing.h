/* The housing mode z'' + a z' + b z = b K T_res with a = 2 zeta w0, b = w0^2, in closed form.
 *
 * Over a step of length h, T_res is the parabola through its values at the start, the middle and
 * the end. The mode's answer is then linear in (z, z') and these three values; the coefficients
 * depend on h alone. They follow from c, the answer to a unit impulse, and its running integrals.
 * Their derivatives by w0 and zeta carry the sensitivities of those two parameters: the steps are
 * linear, so is the derivative of a step. */

typedef struct {
    double z_z, z_v, z_start, z_middle, z_end; /* z' stands as v */
    double v_z, v_v, v_start, v_middle, v_end;
} ModeStep;

typedef struct {
    double h;
    ModeStep value, by_w0, by_zeta;
} Propagator;

typedef struct {
    double c, c_dot, I1, I2, I3; /* the impulse response, its rate and its integrals */
} Impulse;

typedef struct {
    double a, b, force; /* force: the factor of T_res on the right */
} Mode2;

/* Assemble a step from the impulse response; the arguments may be values or differentials. */
static ALWAYS_INLINE ModeStep mode_step(double h, Impulse w, double z_z, double v_z, Impulse f)
{
    const double r = 1.0 / h, q = 4.0 / (h * h);
    return (ModeStep){
        z_z, w.c,     f.I1 - 3 * r * f.I2 + q * f.I3, 4 * r * f.I2 - 2 * q * f.I3, q * f.I3 - r * f.I2,
        v_z, w.c_dot, f.c - 3 * r * f.I1 + q * f.I2,  4 * r * f.I1 - 2 * q * f.I2, q * f.I2 - r * f.I1};
}

static ALWAYS_INLINE Impulse scaled(Impulse w, double k)
{
    return (Impulse){k * w.c, k * w.c_dot, k * w.I1, k * w.I2, k * w.I3};
}

static ALWAYS_INLINE Impulse sum(Impulse w, Impulse x)
{
    return (Impulse){w.c + x.c, w.c_dot + x.c_dot, w.I1 + x.I1, w.I2 + x.I2, w.I3 + x.I3};
}

/* Differential of a step for differentials of (a, b, force); q1, q2 are q', q'' of q = c * c. */
static ALWAYS_INLINE ModeStep mode_step_differential(
    double h, Mode2 m, Impulse w, double q, Mode2 d)
{
    const double q1 = 0.5 * h * w.c - 0.5 * m.a * q;
    const double q2 = w.c - m.a * q1 - m.b * q;
    Impulse x = {.c = -q1 * d.a - q * d.b, .c_dot = -q2 * d.a - q1 * d.b};
    x.I1 = -(x.c_dot + d.a * w.c + m.a * x.c + d.b * w.I1) / m.b;
    x.I2 = -(x.c + d.a * w.I1 + m.a * x.I1 + d.b * w.I2) / m.b;
    x.I3 = -(x.I1 + d.a * w.I2 + m.a * x.I2 + d.b * w.I3) / m.b;
    return mode_step(h, x, x.c_dot + d.a * w.c + m.a * x.c, -d.b * w.c - m.b * x.c,
                     sum(scaled(x, m.force), scaled(w, d.force)));
}

static __attribute__((noinline)) Propagator propagator(const Values *p, double h, int with_jacobian)
{
    const double gain = p->K_res * p->J_rot; /* the loop feeds T_res / J_rot */
    const Mode2 m = {2 * p->zeta * p->w0, p->w0 * p->w0, gain * p->w0 * p->w0};
    const double wd = p->w0 * sqrt(1 - p->zeta * p->zeta), decay = exp(-p->zeta * p->w0 * h);
    double sine, cosine;
    sincos(wd * h, &sine, &cosine);
    Impulse w = {.c = decay * sine / wd};
    w.c_dot = decay * cosine - 0.5 * m.a * w.c;
    w.I1 = (1 - w.c_dot - m.a * w.c) / m.b;
    w.I2 = (h - w.c - m.a * w.I1) / m.b;
    w.I3 = (0.5 * h * h - w.I1 - m.a * w.I2) / m.b;
    Propagator out = {.h = h};
    out.value = mode_step(h, w, w.c_dot + m.a * w.c, -m.b * w.c, scaled(w, m.force));
    if (with_jacobian) {
        const double q = decay * (sine - wd * h * cosine) / (2 * wd * wd * wd);
        out.by_w0 = mode_step_differential(
            h, m, w, q, (Mode2){2 * p->zeta, 2 * p->w0, 2 * gain * p->w0});
        out.by_zeta = mode_step_differential(h, m, w, q, (Mode2){2 * p->w0, 0, 0});
    }
    return out;
}
