// Arc tangents for look-ups in tables and textures, the same on every driver.

// atan(small / large) for 0 <= small <= large, to 1e-7; drivers may err by 1e-5. Cephes' polynomial below tan(pi/8).
float precise_atan(float small, float large)
{
    if (large == 0.0)
        return 0.0;
    bool halve = small > 0.41421356 * large;
    float t = halve ? (small - large) / (small + large) : small / large;
    float q = t * t;
    float angle = t + t * q * (-0.33332949 + q * (0.19977711 + q * (-0.13877686 + q * 0.080537446)));
    return halve ? angle + 0.78539816 : angle;
}

// atan(y, x) for x, y >= 0.
float precise_angle(float y, float x)
{
    return y > x ? 1.57079633 - precise_atan(x, y) : precise_atan(y, x);
}

// atan(y, x) for y >= 0, as a number of quarter turns and what is missing to it or goes beyond it.
float precise_quarter(float y, float x, out int quarters)
{
    float side = abs(x);
    quarters = y > side ? 1 : (x < 0.0 ? 2 : 0);
    float rest = y > side ? precise_atan(side, y) : precise_atan(y, side);
    return (y > side) == (x < 0.0) ? rest : -rest;
}
