#include "config/model_file.hpp"

#include "config/text_file.hpp"
#include "config/yaml_layout.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/identify/regression_field.hpp"
#include "core/judge/model_noise.hpp"

namespace truepose::config {

namespace {

constexpr double kUnit = 1e-9;  // how far a length may be from 1

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

/// Counts from 1 in the file.
struct FromOne {
  int form_of(int index) const { return index + 1; }
  int value_of(int number) const { return number - 1; }
};

/// The deviations of an arm of so many joints.
struct Terms {
  struct Term {
    DeviationTerm term;
    int joints;
  };
  int joints;

  std::vector<Term> form_of(const std::vector<DeviationTerm>& terms) const {
    std::vector<Term> form;
    for (const DeviationTerm& term : terms) form.push_back({term, joints});
    return form;
  }
  void read(const YamlValue& list, std::vector<DeviationTerm>& terms) const {
    for (const YamlValue& each : list.list()) {
      Term form{{}, joints};
      read_value(each, form);
      terms.push_back(form.term);
    }
  }
};

/// A residual field: the data it was fitted to and its hyper-parameters.
struct FieldForm {
  struct Field {
    const RobotModel& robot;
    RegressorState state;
    Eigen::Vector3d p_F_mm{0, 0, 0};
  };
  const RobotModel& robot;  ///< whose joints say how many features it has

  Field form_of(const std::shared_ptr<const ResidualField>& field) const {
    // The only class of fields; a cast that fails rather than a field that is lost.
    const auto& fitted = dynamic_cast<const RegressionField&>(*field);
    return {robot, fitted.regressor()->state(), fitted.p_F_mm()};
  }
  void read(const YamlValue& value, std::shared_ptr<const ResidualField>& field) const {
    Field form{robot, {}};
    read_value(value, form);
    const auto regressor = restore_regressor(form.state);
    if (!regressor) value.fail(regressor.error());
    field = std::make_shared<RegressionField>(robot, *regressor, form.p_F_mm);
  }
};

/// The lower triangle of a covariance, row by row.
struct LowerTriangle {
  const CalibratedCell& cell;  ///< whose parameters these are

  std::vector<std::vector<double>> form_of(const Eigen::MatrixXd& covariance) const {
    std::vector<std::vector<double>> rows;
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      rows.emplace_back();
      for (Eigen::Index j = 0; j <= i; ++j) rows.back().push_back(covariance(i, j));
    }
    return rows;
  }
  void read(const YamlValue& value, Eigen::MatrixXd& covariance) const {
    const int size = ParameterLayout::of(cell).size();
    const std::vector<YamlValue>& rows = value.list();
    if (rows.size() != static_cast<std::size_t>(size))
      value.fail("expected a row for each of " + std::to_string(size) + " parameters");
    covariance.resize(size, size);
    for (int i = 0; i < size; ++i) {
      const YamlValue& row = rows[static_cast<std::size_t>(i)];
      if (row.list().size() != static_cast<std::size_t>(i) + 1)
        row.fail("expected " + std::to_string(i + 1) + " numbers, the lower triangle up to the diagonal");
      for (int j = 0; j <= i; ++j)
        covariance(i, j) = covariance(j, i) = row.list()[static_cast<std::size_t>(j)].number(kAny);
    }
  }
};

// ---- Layouts; mm, rad and kg

void layout(auto& io, Is<Joint> auto& x) {
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

void layout(auto& io, Is<Terms::Term> auto& x) {
  constexpr int kHighestOrder = 100'000;
  io("joint", x.term.joint, FromOne{}, Whole{1, x.joints});
  io("basis", x.term.basis, kDeviationBases);
  const bool frame = x.term.basis == DeviationBasis::Weight;  // its order is a link frame's number
  io.defaulted("order", x.term.order, Whole{1, frame ? x.joints + 1 : kHighestOrder});
  io("coefficient", x.term.coefficient);
}

void layout(auto& io, Is<FieldForm::Field> auto& x) {
  io("kind", x.state.kind, kRegressorNames);
  io("point", x.p_F_mm, kPoint);
  io("hyper", x.state.hyper);
  io("x", x.state.X, Rows{{field_features(x.robot)}});
  io("y", x.state.Y, Rows{{3, 6}});
  io.optional("weights", x.state.weights);
}

/// What goes beyond geometry may be absent.
void layout(auto& io, Is<RobotModel> auto& x) {
  io("name", x.name);
  io("joints", x.joints, JointCount{});
  io("flange", x.X_flange, ThreeRowsOfFour{}, kMm);
  io.defaulted("gravity", x.gravity_B, UnitVector{});
  io.optional("masses", x.masses, OnePerJoint{x.joints.size()});
  io.optional("torque_joints", x.torque_joints, OnePerJoint{x.joints.size()});
  io.optional("deviation", x.deviation, Terms{x.joint_count()});
  io.optional("field", x.field, FieldForm{x});
}

void layout(auto& io, Is<Reflector> auto& x) {
  io("name", x.name);
  layout_xyz(io, x.p_FS_mm, kMm);
}

void layout(auto& io, Is<MeasurementNoise> auto& x) {
  constexpr Range kNoise{0, kMm.max};
  io("range_mm", x.tracker.range_mm, kNoise);
  io("range_mm_per_m", x.tracker.range_mm_per_m, kNoise);
  io("transverse_mm", x.tracker.transverse_mm, kNoise);
  io("transverse_mm_per_m", x.tracker.transverse_mm_per_m, kNoise);
  io("repeatability_mm", x.repeatability_mm, kNoise);
}

void layout(auto& io, Is<ModelFile> auto& x) {
  io("name", x.name);
  io("serial", x.serial, MayBeEmpty{});
  io("created", x.created, MayBeEmpty{});
  io("validation_mean_mm", x.validation_mean_mm, Range{0, kMm.max});
  io("robot", x.cell.robot);
  io("base", x.cell.base);
  io("reflectors", x.cell.reflectors);
  io("parameters", x.parameters);
  io.optional("noise", x.noise);
  io.optional("covariance", x.covariance, LowerTriangle{x.cell});
}

std::optional<DriftReference> drift_reference(const ModelFile& model,
                                              const std::optional<MeasurementNoise>& stated) {
  DriftReference reference{
      .cell = model.cell, .covariance = model.covariance, .validation_mean_mm = model.validation_mean_mm};
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

std::string model_yaml(const ModelFile& model) {
  return "# A calibrated arm. mm, rad and kg; R = Rz(rz) Ry(ry) Rx(rx); flange: three rows of four; joints "
         "count from 1.\n" +
         yaml_of(model);
}

ModelFile parse_model(const std::string& text, const std::string& file_name) {
  ModelFile model;
  read_value(parse_yaml(text, file_name), model);
  return model;
}

ModelFile load_model(const std::filesystem::path& file) {
  return parse_model(read_text_file(file, kMostBytesOfYaml), file.string());
}

}  // namespace truepose::config
