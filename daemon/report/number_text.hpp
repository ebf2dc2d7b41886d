#pragma once

#include <string>

namespace truepose::report {

/// An error in mm to the micrometre, "0.021"; smaller ones keep a digit that says something, "3.1e-13".
std::string error_text(double mm);

/// "0.091 ± 0.003": an error in mm and its standard deviation.
std::string error_text(double mm, double deviation_mm);

/// A length in mm to the micrometre.
std::string length_text(double mm);

/// An angle given in rad as degrees, to 0.0001 deg (0.005 mm at a reach of 3 m).
std::string angle_text(double rad);

/// A standard deviation with two significant digits.
std::string sigma_text(double value);

/// "14" for a 14 times smaller error, with a decimal below ten; "-" where nothing is left to divide by.
std::string factor_text(double before, double after);

}  // namespace truepose::report
