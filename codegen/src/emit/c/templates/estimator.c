
/*
 * The estimator: rows rotated into a triangle by fast Givens rotations, free of square roots
 * (Gentleman, Algorithm AS 154, Applied Statistics 23, 1974).
 *
 *     sum of w (x r - y)^2 = (r - r_found)' R' D R (r - r_found) + rest
 *
 * R is upper triangular with a unit diagonal, D diagonal.
 */

/* Bounds within which no rotation overflows: of entries, of information, of a row's weight. */
static const {{ real }} {{ name }}_limit = {{ estimator.limit }};
static const {{ real }} {{ name }}_least = {{ estimator.least }};
static const {{ real }} {{ name }}_light = {{ estimator.light }};
/* Share of a column, as a length, that is more than rounding. */
static const {{ real }} {{ name }}_independent = {{ estimator.independent }};

/* Where line i of the triangle begins. */
static uint32_t {{ name }}_line(uint32_t i)
{
    return (i * ({{ 2 * base_params + 1 }}u - i)) / 2u;
}

static {{ real }} {{ name }}_size({{ real }} x)
{
    return (x < {{ estimator.zero }}) ? -x : x;
}

/* Square root of a positive number, within one unit in the last place: Newton's method. */
static {{ real }} {{ name }}_root({{ real }} x)
{
    {{ estimator.bits }} bits;
    {{ real }} root;
    (void)memcpy(&bits, &x, sizeof bits);
    bits = (bits >> 1u) + {{ estimator.root }};
    (void)memcpy(&root, &bits, sizeof root);
    for (uint32_t k = 0u; k < {{ estimator.steps }}u; k += 1u) {
        root = {{ estimator.half }} * (root + (x / root));
    }
    return root;
}

/* What the weight of each line must exceed for its parameter to be observable. */
static void {{ name }}_thresholds(const {{ name }}_estimator *e, {{ real }} least[])
{
    for (uint32_t i = 0u; i < {{ base_params }}u; i += 1u) {
        least[i] = e->triangle[{{ name }}_line(i)];
    }
    for (uint32_t i = 0u; i < {{ base_params }}u; i += 1u) {
        const uint32_t line = {{ name }}_line(i);
        const {{ real }} weight = e->triangle[line];
        for (uint32_t k = i + 1u; k < {{ base_params }}u; k += 1u) {
            const {{ real }} r = e->triangle[line + (k - i)];
            least[k] = least[k] + ((weight * r) * r);
        }
    }
    for (uint32_t i = 0u; i < {{ base_params }}u; i += 1u) {
        least[i] = ({{ name }}_independent * {{ name }}_independent) * least[i];
    }
}

/* Whether the pivot of column i is what cancellation leaves of larger terms. */
static int {{ name }}_is_rounding(
    const {{ name }}_estimator *e,
    const {{ real }} row[],
    uint32_t i)
{
    const {{ real }} pivot = {{ name }}_size(row[i]);
    {{ real }} terms = pivot;
    int is_rounding = 0;
    for (uint32_t k = 0u; k < i; k += 1u) {
        terms = terms + {{ name }}_size(row[k] * e->triangle[{{ name }}_line(k) + (i - k)]);
    }
    if (pivot <= ({{ name }}_independent * terms)) {
        is_rounding = 1;
    }
    return is_rounding;
}

/*
 * The error of a prediction over its deviation. Sums of two, four, ... of them over the root of
 * their number scatter as one does where noise is independent, and more where it lasts
 * (Flyvbjerg and Petersen, Journal of Chemical Physics 91, 1989).
 */
static void {{ name }}_take_error({{ name }}_estimator *e, uint32_t axis, {{ real }} error)
{
    const uint32_t first = axis * {{ estimator.levels }}u;
    uint32_t waits = e->predicted[axis];
    {{ real }} sum = error;
    int is_whole = 1;
    e->predicted[axis] = waits + 1u;
    for (uint32_t k = 0u; k < {{ estimator.levels }}u; k += 1u) {
        const uint32_t level = first + k;
        if (is_whole != 0) {
            e->squares[level] = e->squares[level] + (sum * sum);
            e->sums[level] = e->sums[level] + {{ estimator.one }};
            if ((waits & 1u) == 0u) {
                e->waiting[level] = sum;
                is_whole = 0;
            } else {
                sum = (e->waiting[level] + sum) * {{ estimator.half_root }};
                waits >>= 1u;
            }
        }
    }
}

/*
 * Rotate a row over its deviation, and its value, into the triangle. Gives the error of the
 * prediction by the rows before, over its deviation; zero where they predicted nothing.
 */
static {{ real }} {{ name }}_take_row({{ name }}_estimator *e, {{ real }} row[], {{ real }} value)
{
    {{ real }} y = value;
    {{ real }} weight = {{ estimator.one }};
    for (uint32_t i = 0u; i < {{ base_params }}u; i += 1u) {
        const uint32_t line = {{ name }}_line(i);
        const {{ real }} before = e->triangle[line];
        const {{ real }} pivot = row[i];
        const {{ real }} information = (weight * pivot) * pivot;
        int skips = 0;
        if (information < {{ name }}_least) {
            skips = 1;
        } else if (!(before > {{ estimator.zero }})) {
            /* The first pivot of a column decides what the line means: rounding may not. */
            skips = {{ name }}_is_rounding(e, row, i);
        } else {
            /* The line has its meaning. */
        }
        if (skips == 0) {
            const {{ real }} sum = before + information;
            const {{ real }} c = before / sum;
            const {{ real }} s = (weight * pivot) / sum;
            const {{ real }} right = e->values[i];
            e->triangle[line] = sum;
            if ((c + c) > {{ estimator.one }}) {
                for (uint32_t k = i + 1u; k < {{ base_params }}u; k += 1u) {
                    const {{ real }} r = e->triangle[line + (k - i)];
                    const {{ real }} x = row[k] - (pivot * r);
                    row[k] = x;
                    e->triangle[line + (k - i)] = r + (s * x);
                }
                y = y - (pivot * right);
                e->values[i] = right + (s * y);
            } else {
                for (uint32_t k = i + 1u; k < {{ base_params }}u; k += 1u) {
                    const {{ real }} r = e->triangle[line + (k - i)];
                    const {{ real }} x = row[k];
                    row[k] = x - (pivot * r);
                    e->triangle[line + (k - i)] = (c * r) + (s * x);
                }
                e->values[i] = (c * right) + (s * y);
                y = y - (pivot * right);
            }
            weight = c * weight;
            /* A light row is rewritten with a larger weight, in {{ estimator.rounds }} rounds at most. */
            for (uint32_t round = 0u; round < {{ estimator.rounds }}u; round += 1u) {
                if ((weight > {{ estimator.zero }}) && (weight < {{ name }}_light)) {
                    weight = weight / ({{ name }}_light * {{ name }}_light);
                    y = y * {{ name }}_light;
                    for (uint32_t k = 0u; k < {{ base_params }}u; k += 1u) {
                        row[k] = row[k] * {{ name }}_light;
                    }
                }
            }
        }
    }
    e->residual = e->residual + ((weight * y) * y);
    if (weight > {{ estimator.zero }}) {
        y = {{ name }}_root(weight) * y;
    } else {
        y = {{ estimator.zero }};
    }
    return y;
}

/* 0 and e empty about r, or 1 and e as it was. */
static int {{ name }}_begin(
    {{ name }}_estimator *e,
    const {{ real }} r[],
    const {{ real }} cop_std[])
{
    int refused = 0;
    for (uint32_t axis = 0u; axis < 2u; axis += 1u) {
        const {{ real }} std = cop_std[axis];
        /* A NaN is refused. */
        if (!((std > {{ estimator.zero }}) && (std <= {{ name }}_limit) && (({{ estimator.one }} / std) <= {{ name }}_limit))) {
            refused = 1;
        }
    }
    for (uint32_t k = 0u; k < {{ base_params }}u; k += 1u) {
        if (!({{ name }}_size(r[k]) <= {{ name }}_limit)) {
            refused = 1;
        }
    }
    if (refused == 0) {
        for (uint32_t k = 0u; k < {{ estimator.entries }}u; k += 1u) {
            e->triangle[k] = {{ estimator.zero }};
        }
        for (uint32_t k = 0u; k < {{ base_params }}u; k += 1u) {
            e->values[k] = {{ estimator.zero }};
            e->nominal[k] = r[k];
        }
        e->weights[0] = {{ estimator.one }} / cop_std[0];
        e->weights[1] = {{ estimator.one }} / cop_std[1];
        e->residual = {{ estimator.zero }};
        e->postures = 0u;
        for (uint32_t axis = 0u; axis < 2u; axis += 1u) {
            e->predicted[axis] = 0u;
        }
        for (uint32_t k = 0u; k < {{ 2 * estimator.levels }}u; k += 1u) {
            e->waiting[k] = {{ estimator.zero }};
            e->squares[k] = {{ estimator.zero }};
            e->sums[k] = {{ estimator.zero }};
        }
    }
    return refused;
}

int {{ name }}_estimator_init(
    {{ name }}_estimator *e,
    const {{ name }}_real r[],
    const {{ name }}_real r_std[],
    const {{ name }}_real cop_std[])
{
    int refused = 0;
    for (uint32_t k = 0u; k < {{ base_params }}u; k += 1u) {
        const {{ real }} std = r_std[k];
        /* A NaN is refused. */
        if (!((std > {{ estimator.zero }}) && (({{ estimator.one }} / std) <= {{ name }}_limit))) {
            refused = 1;
        }
    }
    if (refused == 0) {
        refused = {{ name }}_begin(e, r, cop_std);
    }
    if (refused == 0) {
        for (uint32_t k = 0u; k < {{ base_params }}u; k += 1u) {
            const {{ real }} weight = {{ estimator.one }} / r_std[k];
            if ((weight * weight) >= {{ name }}_least) {
                e->triangle[{{ name }}_line(k)] = weight * weight;
            }
        }
    }
    return refused;
}
{%- if estimator.resumes %}

int {{ name }}_estimator_resume({{ name }}_estimator *e, const {{ name }}_real cop_std[])
{
    const int refused = {{ name }}_begin(e, {{ name }}_model_params, cop_std);
    if (refused == 0) {
        for (uint32_t i = 0u; i < {{ base_params }}u; i += 1u) {
            const uint32_t line = {{ name }}_line(i);
            const {{ real }} pivot = {{ name }}_model_information[line];
            if ((pivot * pivot) >= {{ name }}_least) {
                e->triangle[line] = pivot * pivot;
                for (uint32_t k = 1u; k < ({{ base_params }}u - i); k += 1u) {
                    e->triangle[line + k] = {{ name }}_model_information[line + k] / pivot;
                }
            }
        }
    }
    return refused;
}
{%- endif %}

int {{ name }}_estimator_add(
    {{ name }}_estimator *e,
    const {{ name }}_real q[],
    const {{ name }}_real reading[])
{
    {{ real }} rows[{{ 2 * base_params }}];
    {{ real }} cop[2];
    int refused = 0;
    {{ name }}_regressor_cop(q, rows);
{%- if estimator.corrects %}
    {{ name }}_correct_cop(reading, cop);
{%- else %}
    cop[0] = reading[0];
    cop[1] = reading[1];
{%- endif %}
    for (uint32_t axis = 0u; axis < 2u; axis += 1u) {
        const {{ real }} weight = e->weights[axis];
        {{ real }} off = cop[axis];
        for (uint32_t k = 0u; k < {{ base_params }}u; k += 1u) {
            const uint32_t at = (axis * {{ base_params }}u) + k;
            off = off - (rows[at] * e->nominal[k]);
            rows[at] = rows[at] * weight;
            /* A NaN is refused. */
            if (!({{ name }}_size(rows[at]) <= {{ name }}_limit)) {
                refused = 1;
            }
        }
        cop[axis] = off * weight;
        if (!({{ name }}_size(cop[axis]) <= {{ name }}_limit)) {
            refused = 1;
        }
    }
    if (refused == 0) {
        for (uint32_t axis = 0u; axis < 2u; axis += 1u) {
            cop[axis] = {{ name }}_take_row(e, &rows[axis * {{ base_params }}u], cop[axis]);
        }
        for (uint32_t axis = 0u; axis < 2u; axis += 1u) {
            /* No number is less or more than another where nothing was predicted. */
            if ((cop[axis] < {{ estimator.zero }}) || (cop[axis] > {{ estimator.zero }})) {
                {{ name }}_take_error(e, axis, cop[axis]);
            }
        }
        if (e->postures < UINT32_MAX) {
            e->postures += 1u;
        }
    }
    return refused;
}

/* Back substitution over the observable lines. */
static void {{ name }}_params_above(
    const {{ name }}_estimator *e,
    const {{ real }} least[],
    {{ real }} r[])
{
    for (uint32_t n = 0u; n < {{ base_params }}u; n += 1u) {
        const uint32_t i = {{ base_params - 1 }}u - n;
        const uint32_t line = {{ name }}_line(i);
        r[i] = {{ estimator.zero }};
        if (e->triangle[line] > least[i]) {
            {{ real }} sum = {{ estimator.zero }};
            for (uint32_t k = i + 1u; k < {{ base_params }}u; k += 1u) {
                sum = sum + (e->triangle[line + (k - i)] * r[k]);
            }
            r[i] = e->values[i] - sum;
        }
    }
    for (uint32_t k = 0u; k < {{ base_params }}u; k += 1u) {
        r[k] = e->nominal[k] + r[k];
    }
}

void {{ name }}_estimator_params(const {{ name }}_estimator *e, {{ name }}_real r[])
{
    {{ real }} least[{{ base_params }}];
    {{ name }}_thresholds(e, least);
    {{ name }}_params_above(e, least, r);
}

void {{ name }}_estimator_solve(
    const {{ name }}_estimator *e,
    {{ name }}_real r[],
    {{ name }}_real r_std[])
{
    {{ real }} least[{{ base_params }}];
    {{ real }} row[{{ base_params }}];
    {{ name }}_thresholds(e, least);
    {{ name }}_params_above(e, least, r);
    for (uint32_t parameter = 0u; parameter < {{ base_params }}u; parameter += 1u) {
        const uint32_t first = {{ name }}_line(parameter);
        if (e->triangle[first] > least[parameter]) {
            /* The row that is 1 at the parameter, its own line taken off. */
            {{ real }} variance = {{ estimator.one }} / e->triangle[first];
            for (uint32_t k = parameter + 1u; k < {{ base_params }}u; k += 1u) {
                row[k] = -e->triangle[first + (k - parameter)];
            }
            for (uint32_t i = parameter + 1u; i < {{ base_params }}u; i += 1u) {
                const uint32_t line = {{ name }}_line(i);
                const {{ real }} weight = e->triangle[line];
                const {{ real }} pivot = row[i];
                if (weight > least[i]) {
                    variance = variance + ((pivot * pivot) / weight);
                    for (uint32_t k = i + 1u; k < {{ base_params }}u; k += 1u) {
                        row[k] = row[k] - (pivot * e->triangle[line + (k - i)]);
                    }
                }
            }
            r_std[parameter] = {{ name }}_root(variance);
        } else {
            r_std[parameter] = ({{ real }})INFINITY;
        }
    }
}

/* Postures of one axis per independent one. */
static {{ real }} {{ name }}_postures_per_sample(const {{ name }}_estimator *e, uint32_t axis)
{
    const uint32_t first = axis * {{ estimator.levels }}u;
    {{ real }} most = {{ estimator.one }};
    int is_known = 1;
    for (uint32_t k = 1u; k < {{ estimator.levels }}u; k += 1u) {
        const uint32_t level = first + k;
        if (!(e->sums[level] >= {{ estimator.fewest }})) {
            is_known = 0;
        }
        if (is_known != 0) {
            const {{ real }} one = e->squares[first] / e->sums[first];
            const {{ real }} ratio = (e->squares[level] / e->sums[level]) / one;
            /* A mean of n squares of normal numbers has the variance 2/n. */
            const {{ real }} off = ratio - {{ estimator.one }};
            const {{ real }} variance = {{ estimator.two }} / e->sums[level];
            if ((ratio > most) && ((off * off) > ({{ estimator.clear }} * variance))) {
                most = ratio;
            }
        }
    }
    return most;
}

{{ name }}_real {{ name }}_estimator_independent_postures(const {{ name }}_estimator *e)
{
    const {{ real }} of_x = {{ name }}_postures_per_sample(e, 0u);
    const {{ real }} of_y = {{ name }}_postures_per_sample(e, 1u);
    return (({{ real }})e->postures) / ((of_x > of_y) ? of_x : of_y);
}
