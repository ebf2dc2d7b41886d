#include "config/model_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "config/document_kind.hpp"
#include "config/lower_triangle.hpp"
#include "config/sealed_text.hpp"
#include "config/text_file.hpp"
#include "config/yaml_layout.hpp"
#include "core/arm/guide.hpp"
#include "core/compensate/largest_correction.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/field/gaussian_process.hpp"
#include "core/fit/regression_field.hpp"
#include "core/formatted.hpp"
#include "core/math/statistics.hpp"
#include "core/math/units.hpp"
#include "core/named.hpp"
#include "core/quality/model_noise.hpp"

namespace truepose::config {

namespace {

constexpr double kUnit = 1e-9;  // how far a length may be from 1
constexpr int kLastReflector = 100;

}  // namespace

struct JointCount {
  std::string fault(const std::vector<Joint>& joints) const {
    if (!joints.empty() && joints.size() <= kMaxJoints) return {};
    return "expected 1.." + std::to_string(kMaxJoints) + " joints, found " + std::to_string(joints.size());
  }
};

/// As many as there are joints.
struct OnePerJoint {
  std::size_t joints;
  template <class T>
  std::string fault(const std::vector<T>& list) const {
    if (list.size() == joints) return {};
    return "expected " + std::to_string(joints) + ", one per joint, found " + std::to_string(list.size());
  }
};

/// Three rows of four: the rotation is kept as it is, angles would round it.
struct ThreeRowsOfFour {
  static constexpr std::size_t kNumbers = 12;

  std::vector<double> form_of(const Eigen::Isometry3d& X) const {
    std::vector<double> numbers;
    for (int i = 0; i < static_cast<int>(kNumbers); ++i) numbers.push_back(X(i / 4, i % 4));
    return numbers;
  }
  Eigen::Isometry3d value_of(const std::vector<double>& numbers) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (int i = 0; i < static_cast<int>(kNumbers); ++i)
      X(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
    return X;
  }
  std::string_view fault(const std::vector<double>& numbers) const {
    if (numbers.size() != kNumbers) return "expected 12 numbers";
    return value_of(numbers).linear().isUnitary(kUnit) ? "" : "not a rotation";
  }
};

/// Not made a unit vector again: that would change its last digit.
struct UnitVector : Xyz {
  constexpr UnitVector() : Xyz{kMm} {}
  std::string_view fault(const Form& form) const {
    return std::abs(form.p.norm() - 1) > kUnit ? "expected a direction of length 1" : "";
  }
};

/// The deviations of an arm of these joints.
struct Terms {
  struct Term {
    DeviationTerm term;
    int joints;
  };
  const std::vector<Joint>& joints;

  int count() const { return static_cast<int>(joints.size()); }
  std::vector<Term> form_of(const std::vector<DeviationTerm>& terms) const {
    std::vector<Term> form;
    for (const DeviationTerm& term : terms) form.push_back({term, count()});
    return form;
  }
  void read(const Io& io, std::vector<DeviationTerm>& terms) const {
    std::set<int> guided;
    for (const YamlValue& each : yaml_value(io).list()) {
      Term form{{}, count()};
      read_value(each, form);
      terms.push_back(form.term);
      if (guide_motion(form.term.basis) < 0) continue;
      const Joint& joint = joints[static_cast<std::size_t>(form.term.joint)];
      if (joint.type != JointType::Prismatic || !(joint.min < joint.max))
        each.fail("a guide is that of a prismatic joint with a way from min to max");
      guided.insert(form.term.joint);
      if (guided.size() > kMostGuides)
        each.fail("expected guides of at most " + std::to_string(kMostGuides) + " joints");
    }
  }
};

/// A residual field: the data it was fitted to and its hyper-parameters.
struct FieldForm {
  enum class Kind { GaussianProcess };
  static constexpr std::array kKinds{Named{"gp", Kind::GaussianProcess}};
  struct Field {
    const RobotModel& robot;
    RegressorState state;
    Kind kind = Kind::GaussianProcess;
    Eigen::Vector3d p_F_mm{0, 0, 0};
    double variance_factor = 1;
  };
  const RobotModel& robot;  ///< whose joints say how many features it has

  Field form_of(const std::shared_ptr<const ResidualField>& field) const {
    // The only class of fields; a cast that fails rather than a field that is lost.
    const auto& fitted = dynamic_cast<const RegressionField&>(*field);
    return {.robot = robot,
            .state = fitted.regressor()->state(),
            .p_F_mm = fitted.p_F_mm(),
            .variance_factor = fitted.variance_factor()};
  }
  void read(const Io& io, std::shared_ptr<const ResidualField>& field) const {
    const YamlValue& value = yaml_value(io);
    Field form{.robot = robot, .state = {}};
    read_value(value, form);
    const auto regressor = restore_gaussian_process(form.state);
    if (!regressor) value.fail(regressor.error());
    field = std::make_shared<RegressionField>(robot, *regressor, form.p_F_mm, form.variance_factor);
  }
};

/// Rows of equally many numbers.
struct RowsOfAnyLength : Rows {
  void read(const Io& io, Eigen::MatrixXd& A) const {
    const std::vector<YamlValue>& rows = yaml_value(io).list();
    Rows{{rows.empty() ? 0 : static_cast<int>(rows.front().list().size())}}.read(io, A);
  }
};

// ---- Layouts; mm, rad and kg

}  // namespace truepose::config

namespace truepose::record {

using config::FieldForm, config::JointCount, config::OnePerJoint, config::RowsOfAnyLength, config::Terms,
    config::ThreeRowsOfFour, config::UnitVector;

void layout(Io& io, Joint& x) {
  io.optional("type", Unless{JointType::Revolute, x.type}, kJointTypes);
  io("a", x.a_mm, kMm);
  io("alpha", x.alpha_rad, kRad);
  io("d", x.d_mm, kMm);
  io("theta", x.theta_rad, kRad);
  io("beta", x.beta_rad, kRad);
  io("sign", x.sign, Range{-1, 1});
  io("min", x.min);
  io("max", x.max);
  io("speed", x.speed);
  io.defaulted("acceleration", x.acceleration);
}

/// What goes beyond geometry may be absent.
void layout(Io& io, RobotModel& x) {
  io("name", x.name);
  io("joints", x.joints, JointCount{});
  io.optional("coupling", x.coupling, Couplings::of(x.joints));
  io("flange", x.X_flange, ThreeRowsOfFour{}, kMm);
  io.defaulted("gravity", x.gravity_B, UnitVector{});
  io.optional("masses", x.masses, OnePerJoint{x.joints.size()});
  io.optional("payload", x.payload);
  io.optional("torque_joints", x.torque_joints, OnePerJoint{x.joints.size()});
  io.optional("non_geometric", x.deviation, Terms{x.joints});
  io.optional("field", x.field, FieldForm{x});
}

void layout(Io& io, Reflector& x) {
  io("name", x.name);
  layout_xyz(io, x.p_FS_mm, kMm);
}

void layout(Io& io, MeasurementNoise& x) {
  constexpr Range kNoise{0, kMm.max};
  io("range_mm", x.tracker.range_mm, kNoise);
  io("range_mm_per_m", x.tracker.range_mm_per_m, kNoise);
  io("transverse_mm", x.tracker.transverse_mm, kNoise);
  io("transverse_mm_per_m", x.tracker.transverse_mm_per_m, kNoise);
  io("repeatability_mm", x.repeatability_mm, kNoise);
}

void layout(Io& io, ThermalResponse& x) {
  constexpr Range kCelsius{-100, 300};
  io("reference_c", x.reference_c, kCelsius);
  io("per_kelvin", x.per_kelvin);
  io("covariance", x.covariance, RowsOfAnyLength{});
}

}  // namespace truepose::record

namespace truepose::config {

void layout(Io& io, Terms::Term& x) {
  constexpr int kHighestOrder = 100'000;
  io("joint", x.term.joint, FromOne{}, Whole{1, x.joints});
  io("basis", x.term.basis, kDeviationBases);
  // The order of a weight or moment is a link frame's number.
  const int highest = x.term.basis == DeviationBasis::Weight ? x.joints + 1
                      : is_moment(x.term.basis)              ? x.joints
                                                             : kHighestOrder;
  io.defaulted("order", x.term.order, Whole{1, highest});
  io("coefficient", x.term.coefficient);
}

void layout(Io& io, FieldForm::Field& x) {
  io("kind", x.kind, FieldForm::kKinds);
  io("point", x.p_F_mm, kPoint);
  io.defaulted("variance_factor", x.variance_factor, kNotNegative);
  io("hyper", x.state.hyper);
  io("x", x.state.X, Rows{{field_features(x.robot)}});
  io("y", x.state.Y, Rows{{3, 6}});
}

void layout(Io& io, ValidationPoint& x) {
  io("q", x.q);
  io("smr", x.smr, FromOne{}, Whole{1, kLastReflector});
  io.optional("direction", x.direction, Whole{-1, 1});
  io.optional("payload", x.payload);
  io("point", x.p_WS_mm, kPoint);
}

void layout(Io& io, ModelFile& x) {
  io("name", x.name);
  io("serial", x.serial, MayBeEmpty{});
  io("created", x.created, MayBeEmpty{});
  io("validation_mean_mm", x.validation_mean_mm, Range{0, kMm.max});
  io.optional("verdict", x.verdict, ColoredVerdict{});
  io("robot", x.cell.robot);
  io("base", x.cell.base);
  io("reflectors", x.cell.reflectors);
  io("parameters", x.parameters);
  io.optional("updates", x.updates);
  io.optional("several_payloads", Unless{false, x.several_payloads});
  io.optional("station", x.station);
  io.optional("noise", x.noise);
  io.defaulted("misfit_mm", x.misfit_mm, kNotNegative);
  io.optional("validation_distances2", x.validation_distances2);
  io.optional("covariance", x.covariance, LowerTriangle{ParameterLayout::of(x.cell).size()});
  io.optional("thermal", x.thermal);
  io.optional("validation", x.validation);
  io.defaulted("largest_correction_deg", x.largest_correction_deg, kNotNegative);
  io.optional("sha256", x.sha256);
}

void check(const Io& io, const ModelFile& x) {
  if (!x.thermal) return;
  const ThermalResponse& thermal = *x.thermal;
  const Eigen::Index joints = x.cell.robot.joint_count(), parameters = ParameterLayout::of(x.cell).size();
  if (static_cast<Eigen::Index>(thermal.reference_c.size()) == joints && thermal.size() == joints + 1 &&
      thermal.covariance.rows() == thermal.size() && thermal.parameters() == parameters)
    return;
  io.fail_at(
      "thermal",
      formatted("expected %td references, and %td rows of per_kelvin and of a covariance of %td columns",
                joints, joints + 1, parameters + joints + 1));
}

std::optional<DriftReference> drift_reference(const ModelFile& model,
                                              const std::optional<MeasurementNoise>& stated) {
  DriftReference reference{
      .cell = model.cell, .covariance = model.covariance, .validation_mean_mm = model.validation_mean_mm};
  if (!stated) reference.validation_distances2 = model.validation_distances2;
  if (stated) {
    reference.noise = *stated;
  } else if (model.noise) {
    reference.noise = *model.noise;
  } else if (model.validation_mean_mm > 0) {
    reference.noise = noise_of_mean_error(model.validation_mean_mm);
  } else {
    return std::nullopt;
  }
  return reference;
}

bool is_payload_open(const ModelFile& model) {
  const RobotModel& robot = model.cell.robot;
  if (robot.payload || !std::ranges::count(robot.deviation, DeviationBasis::Gravity, &DeviationTerm::basis))
    return false;
  // Without masses of links it takes several payloads to identify the deflection.
  return model.several_payloads || robot.masses.empty();
}

std::vector<ValidationPoint> validation_points(const MeasurementData& data) {
  std::vector<ValidationPoint> points;
  for (const Measurement& m : data.points)
    if (m.set == PoseSet::Validate) points.push_back({m.q, m.smr, m.direction, m.payload, m.p_WS_mm});
  return points;
}

Measurement ValidationPoint::measurement() const {
  return {.q = q, .p_WS_mm = p_WS_mm, .smr = smr, .direction = direction, .payload = payload};
}

std::vector<JointVector> poses_of(std::span<const ValidationPoint> points) {
  std::vector<JointVector> poses;
  for (const ValidationPoint& point : points) poses.push_back(point.q);
  return poses;
}

namespace {

bool suits(const ValidationPoint& point, const CalibratedCell& cell) {
  const auto joints = static_cast<std::size_t>(cell.robot.joint_count());
  return static_cast<std::size_t>(point.q.size()) == joints &&
         static_cast<std::size_t>(point.smr) < cell.reflectors.size() &&
         (point.direction.empty() || point.direction.size() == joints);
}

}  // namespace

std::optional<std::string> other_error(const CalibratedCell& cell, std::span<const ValidationPoint> points,
                                       double made_mm) {
  if (points.empty()) return std::nullopt;
  if (!std::ranges::all_of(points, [&](const ValidationPoint& point) { return suits(point, cell); }))
    return "a point that it was validated on has other joints, or a reflector that it does not know";
  std::vector<Eigen::Vector3d> errors_mm;
  for (const ValidationPoint& point : points)
    errors_mm.push_back(cell.predict(point.measurement()) - point.p_WS_mm);
  const double now_mm = error_statistics(errors_mm).mean;
  // Written so that a NaN is refused as well.
  if (std::abs(now_mm - made_mm) <= kReproduced_mm) return std::nullopt;
  return formatted("it misses its own validation points by %.4f mm on average, when it was made by %.4f mm",
                   now_mm, made_mm);
}

std::optional<std::string> larger_correction(const RobotModel& nominal, const CalibratedCell& cell,
                                             std::span<const JointVector> poses, double made_deg) {
  const double now_deg = made_deg == 0 ? 0 : largest_correction(nominal, cell, poses) * kDegPerRad;
  if (now_deg <= made_deg + kReproduced_deg) return std::nullopt;
  return formatted(
      "it corrects a joint by up to %.3f deg at its own poses; when it was made by %.3f deg (it, "
      "or the robot file, has been changed)",
      now_deg, made_deg);
}

namespace {

/// "link3.a: 1150 mm in the model, 1160 mm in the robot file"
std::string difference(const std::string& name, double made, double now) {
  const bool is_length = name.ends_with(".a") || name.ends_with(".d");
  const double unit = is_length ? 1 : kRadPerDeg;
  const char* word = is_length ? "mm" : "deg";
  return formatted("%s: %.9g %s in the model, %.9g %s in the robot file", name.c_str(), made / unit, word,
                   now / unit, word);
}

std::optional<std::string> other_link(const RobotModel& nominal, const ModelFile& model) {
  const CalibratedCell cell{.robot = nominal};
  const std::vector<std::string> names = parameter_names(cell);
  const Eigen::VectorXd values = parameter_values(cell);
  for (int k = ParameterLayout::of(cell).link(0); k < values.size(); ++k) {
    const std::string& name = names[static_cast<std::size_t>(k)];
    const auto made = std::ranges::find(model.parameters, name, &IdentifiedParameter::name);
    if (made != model.parameters.end() && !(std::abs(made->nominal - values[k]) <= kUnit))
      return difference(name, made->nominal, values[k]);
  }
  return std::nullopt;
}

std::optional<std::string> other_sign(const RobotModel& nominal, const RobotModel& model) {
  for (std::size_t i = 0; i < nominal.joints.size(); ++i) {
    const auto made = static_cast<int>(model.joints[i].sign), now = static_cast<int>(nominal.joints[i].sign);
    if (made != now)
      return formatted("the sign of joint %zu: %d in the model, %d in the robot file", i + 1, made, now);
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> other_nominal(const RobotModel& nominal, const ModelFile& model) {
  std::optional<std::string> other = other_link(nominal, model);
  if (!other) other = other_sign(nominal, model.cell.robot);
  if (!other && nominal.coupling != model.cell.robot.coupling) other = "the coupling of joints";
  if (!other && !nominal.X_flange.isApprox(model.cell.robot.X_flange, kUnit)) other = "the flange";
  if (!other) return std::nullopt;
  return "it was identified from another robot file, " + *other;
}

std::string model_yaml(const ModelFile& model) {
  ModelFile content = model;
  content.sha256.clear();
  return sealed(
      "# A calibrated arm. mm, rad and kg; R = Rz(rz) Ry(ry) Rx(rx); flange: three rows of four; joints "
      "count from 1.\n" +
      yaml_of(content));
}

ModelFile parse_model(const std::string& text, const std::string& file_name) {
  ModelFile model;
  const YamlValue yaml = parse_yaml(text, file_name);
  expect_kind(yaml, DocumentKind::Model);
  read_value(yaml, model);
  check_seal(text, file_name, "identify again");
  return model;
}

ModelFile parse_checked_model(const std::string& text, const std::string& file_name) {
  ModelFile model = parse_model(text, file_name);
  if (const auto why = other_error(model.cell, model.validation, model.validation_mean_mm))
    throw ConfigError(file_name + ": the model is refused: " + *why + "; identify again");
  return model;
}

ModelFile load_model(const std::filesystem::path& file) {
  return parse_checked_model(read_text_file(file, kMostBytesOfYaml), file.string());
}

}  // namespace truepose::config
