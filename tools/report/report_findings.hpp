#pragma once

#include <boost/json/fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace truepose::report {

/// Standard deviations of a stage's errors over the runs of a validation, mm.
struct StageSpread {
  double mean = 0, max = 0, rms = 0;
};

/// How the runs of a validation differ.
struct Spread {
  std::string over;  ///< "splits" or "folds"
  int count = 0;
  StageSpread before, geometric, after;
};

/// A group of joint deviations or a kind of residual field, and the error at unseen poses without and with
/// it, mm.
struct LayerChoice {
  std::string name;
  bool chosen = false;
  double without_mm = 0, with_mm = 0;
  double standard_error_mm = 0;  ///< of with_mm, 0 where not known
};

struct Deviations {
  double geometric_mm = 0;  ///< error at unseen poses without any
  double chosen_mm = 0;     ///< and with those chosen
  std::vector<LayerChoice> groups;
};

struct Residual {
  std::string chosen;  ///< "none" where no field predicts better than zero
  std::vector<LayerChoice> kinds;
};

struct Rejected {
  int row = 0;   ///< 0: not from a file
  int pose = 0;  ///< 0: not known
  std::string smr;
  double residual_mm = 0;
  double sigmas = 0;
};

struct Observability {
  double o1 = 0, o2 = 0, o3 = 0, o4 = 0, o5 = 0;
  std::vector<std::string> unknown, weak;  ///< sentences
};

/// How far the link errors were taken as small before they were measured.
struct PriorScale {
  double length_mm = 0, angle_rad = 0;
};

struct MapAxis {
  int joint = 0;  ///< from 1
  double from = 0, to = 0;
  int count = 0;
};

/// Standard deviation of a predicted position while two joints sweep and the others are held.
struct UncertaintyMap {
  MapAxis x, y;
  std::vector<double> held;                   ///< of every joint, deg or mm
  std::vector<std::vector<double>> sigma_mm;  ///< [y][x]
};

struct Transfer {
  double rms_mm = 0, max_mm = 0;
  std::vector<double> worst_joints;  ///< deg or mm
  std::string warning;               ///< empty: nothing to warn of
  std::vector<UncertaintyMap> maps;
};

/// What the identification learned beside the parameters. A part that the document does not have is left
/// empty.
struct Findings {
  std::optional<Spread> spread;
  std::optional<Deviations> deviations;
  std::optional<Residual> residual;
  std::vector<Rejected> rejected;
  std::optional<Observability> observability;
  std::optional<PriorScale> prior;  ///< where one was used
  std::optional<Transfer> transfer;
  std::optional<MeasurementNoise> noise;  ///< of a point, as the identification took it
  std::optional<double> rank_gap, sigma0_mm;
};

/// Throws std::invalid_argument with one sentence where a member is of the wrong kind.
Findings read_findings(const boost::json::object& document);

/// Chosen ones first, the most useful at the top.
std::vector<LayerChoice> ranked(std::vector<LayerChoice> choices);

}  // namespace truepose::report
