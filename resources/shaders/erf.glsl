// The error function to 1.5e-7 (Abramowitz and Stegun 1964, 7.1.26).
// in: x ≥ 0; out: erf(x).

float erf(float x)
{
    float t = 1.0 / (1.0 + 0.3275911 * x);
    float sum = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    return 1.0 - sum * exp(-x * x);
}
