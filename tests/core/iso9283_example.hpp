#pragma once

#include <Eigen/Core>
#include <array>

/// Thirty cycles at five points, whole micrometres from an integer rule, and their characteristics worked
/// independently of this project with decimals of fifty digits.
namespace truepose::example {

inline Eigen::Vector3d commanded_mm(int point) {
  return {1000.0 + 100 * point, 50.0 * point * point, 800.0 - 70 * point};
}

inline Eigen::Vector3d deviation_mm(int point, int cycle) {
  const int k = point, j = cycle;
  return Eigen::Vector3d((7 * j + 3 * k) % 13 - 6 + 12 * k, (5 * j + k) % 11 - 5 - 7 * k,
                         (3 * j + 2 * k) % 17 - 8 + 3 * k) /
         1000;
}

struct WorkedFigures {
  double ap_x, ap_y, ap_z, ap_p, l_mean, l_std, rp_l;  // mm
};

// E.g. P1: AP_x = 366 um / 30 = 12.2 um, AP_y = -205 / 30, AP_z = 81 / 30.
inline constexpr std::array<WorkedFigures, 5> kWorkedFigures{{
    {0.0122, -0.0068333333333333336, 0.0027, 0.014241644723993238, 0.0065287035466253069,
     0.0019874395820366187, 0.012491022292735163},
    {0.023733333333333332, -0.013933333333333334, 0.006, 0.028167514780130833, 0.0066505758150359308,
     0.0018083005279973413, 0.012075477399027954},
    {0.036133333333333337, -0.021033333333333334, 0.0093, 0.042831167260406165, 0.0064442421597943897,
     0.0023844729260087223, 0.013597660937820557},
    {0.04766666666666667, -0.028133333333333333, 0.012033333333333333, 0.056642710622521117,
     0.0066347640556218149, 0.0019695717877582439, 0.012543479418896546},
    {0.060066666666666664, -0.034866666666666664, 0.015333333333333332, 0.071125241651610577,
     0.0067523584614156938, 0.0016626698124986704, 0.011740367898911705},
}};

}  // namespace truepose::example
