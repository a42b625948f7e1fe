// Powers of numbers near 1.
// in: deficit >= 0 and exponent >= 0; out: max(0, 1 - deficit)^exponent, with 0^0 = 1. No units.
// pow() is undefined at 0^0 and may lose 2^-21 in the logarithm, which the exponent multiplies; so near 1 the
// logarithm comes from its series in s = deficit / (2 - deficit): ln(1 - deficit) = -2 (s + s^3/3 + s^5/5 + ...).

float power_of_one_minus(float deficit, float exponent)
{
    if (exponent == 0.0)
        return 1.0;
    if (deficit >= 1.0)
        return 0.0;
    if (deficit > 0.5)
        return exp2(exponent * log2(1.0 - deficit));
    float s = deficit / (2.0 - deficit);
    float q = s * s;
    float series = 1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0
        + q * (1.0 / 11.0 + q * (1.0 / 13.0 + q / 15.0))))));
    return exp2(exponent * (-2.8853900817779268 * s * series));
}
