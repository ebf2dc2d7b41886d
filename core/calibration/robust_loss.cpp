#include "core/calibration/robust_loss.hpp"

#include <algorithm>
#include <cmath>

#include "core/evaluation/median.hpp"

namespace truepose {

double huber_weight(double length, double knee) { return length <= knee ? 1.0 : knee / length; }

double igg3_weight(double length, double knee, double cut) {
  if (length <= knee) return 1.0;
  if (length >= cut) return 0.0;
  const double left = (cut - length) / (cut - knee);
  return knee / length * left * left;
}

double tukey_weight(double length, double cut) {
  if (length >= cut) return 0.0;
  const double left = 1 - length * length / (cut * cut);
  return left * left;
}

double sigma_from_median(std::span<const double> lengths) {
  constexpr double kMedianOfChi3 = 1.5381722544550522;
  return median({lengths.begin(), lengths.end()}) / kMedianOfChi3;
}

}  // namespace truepose
