{%- if estimator %}

/*
 * Estimator: parameters from postures, one at a time, by least squares
 *
 *     min  sum over postures |(Y(q) r - cop) / std|^2  +  what is known of r before them
 *
 * It holds all its memory, takes nothing from elsewhere, and a posture takes the same time
 * whenever it comes. A copy of the struct goes on where the original stood, also after a
 * power cycle. The rows Y are those of {{ name }}_regressor_cop
 {%- if estimator.corrects %}, and a reading is first freed of the
 * sensor's effects by {{ name }}_correct_cop
 {%- endif %}. Nothing is forgotten; a sum of many
 * million postures grows no further{{ " in float" if suffix }}.
 */
typedef struct {
    /** Row by row: its weight d (1/m^2), then what stands right of the diagonal. */
    {{ name }}_real triangle[{{ estimator.entries }}];
    /** Right-hand sides of the rows, m. */
    {{ name }}_real values[{{ name }}_BASE_PARAMS];
    /** Parameters that the rest is about, m. */
    {{ name }}_real nominal[{{ name }}_BASE_PARAMS];
    /** 1 / std of the CoP in x and y, 1/m. */
    {{ name }}_real weights[2];
    /** Sum of squared residuals over their variances. */
    {{ name }}_real residual;
    /** Postures taken. */
    uint32_t postures;
    /** Predictions in x and y that a reading was compared with. */
    uint32_t predicted[2];
    /** Their errors over their deviations, summed over 1, 2, 4, ... postures: a sum that waits
     * for its neighbour, the squares of all and their number, in x and y. */
    {{ name }}_real waiting[{{ 2 * estimator.levels }}];
    {{ name }}_real squares[{{ 2 * estimator.levels }}];
    {{ name }}_real sums[{{ 2 * estimator.levels }}];
} {{ name }}_estimator;

/**
 * @brief Begin with parameters that are known as r[k] +- r_std[k], each by itself.
 * An infinite r_std says that nothing is known.
 * @param[out] e the estimator
 * @param[in] r parameters, m, [{{ name }}_BASE_PARAMS], such as {{ name }}_cad_params
 * @param[in] r_std their standard deviations, m, [{{ name }}_BASE_PARAMS]
 * @param[in] cop_std standard deviations of a CoP reading, x and y, m, [2]
 * @return 0; 1 and e as it was where a parameter or cop_std is NaN, infinite or above
 *     {{ estimator.far }} m, or a deviation is NaN, not positive or below {{ estimator.narrow }} m.
 */
int {{ name }}_estimator_init(
    {{ name }}_estimator *e,
    const {{ name }}_real r[],
    const {{ name }}_real r_std[],
    const {{ name }}_real cop_std[]);
{%- if estimator.resumes %}

/**
 * @brief Go on from the fit of the model file: {{ name }}_model_params as well known as
 * {{ name }}_model_information says.
 * @param[out] e the estimator
 * @param[in] cop_std standard deviations of a CoP reading, x and y, m, [2]
 * @return 0; 1 and e as it was where a deviation is not positive or below {{ estimator.narrow }} m.
 */
int {{ name }}_estimator_resume({{ name }}_estimator *e, const {{ name }}_real cop_std[]);
{%- endif %}

/**
 * @brief Take one posture of the robot at rest: about 4 N^2 products and sums of N parameters.
 * @param[in,out] e the estimator
 * @param[in] q joint positions, rad (m for prismatic joints), [{{ name }}_DOF]
 * @param[in] reading CoP as the sensor gives it, m, support frame, [2]
 * @return 0; 1 and e as it was where a number is NaN, infinite or more than {{ estimator.far }}
 *     deviations large.
 */
int {{ name }}_estimator_add(
    {{ name }}_estimator *e,
    const {{ name }}_real q[],
    const {{ name }}_real reading[]);

/**
 * @brief The parameters so far, about N^2 products and sums.
 * @param[in] e the estimator
 * @param[out] r parameters, m, [{{ name }}_BASE_PARAMS]; what nothing has shown stays as it began
 */
void {{ name }}_estimator_params(const {{ name }}_estimator *e, {{ name }}_real r[]);

/**
 * @brief The parameters and how well they are known, about N^3 / 3 products and sums.
 * @param[in] e the estimator
 * @param[out] r parameters, m, [{{ name }}_BASE_PARAMS]; what nothing has shown stays as it began
 * @param[out] r_std their standard deviations, m, [{{ name }}_BASE_PARAMS]; infinite where
 *     nothing has shown them
 */
void {{ name }}_estimator_solve(
    const {{ name }}_estimator *e,
    {{ name }}_real r[],
    {{ name }}_real r_std[]);

/**
 * @brief How many independent postures those taken are worth, seen in how errors of predictions
 * last; postures are to come in the order of time. Deviations of {{ name }}_estimator_solve
 * take all as independent: multiply them by the root of postures over this number.
 * @param[in] e the estimator
 * @return at most the postures taken
 */
{{ name }}_real {{ name }}_estimator_independent_postures(const {{ name }}_estimator *e);
{%- endif %}
