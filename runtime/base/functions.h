// Functions that feed the state and must not depend on the C library, whose last digits differ between machines.
#pragma once

namespace feder {

// Relative error about 1e-15. exponential: infinity above 709.78, 0 below -745.14. natural_log of 0 is -infinity, of
// less NaN. power(a, b): products for whole b up to 64, a square root more for half ones, else exp(b ln a), whose error
// grows with |b ln a|; NaN for a < 0 unless b is whole.
double exponential(double x);
double natural_log(double x);
double power(double a, double b);

}  // namespace feder
