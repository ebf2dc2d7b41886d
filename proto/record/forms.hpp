#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/arm/joint_units.hpp"
#include "core/calibrate/calibration.hpp"
#include "core/math/angles.hpp"
#include "core/plan/design.hpp"
#include "core/plan/scene.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "proto/record/arm_document.hpp"
#include "proto/record/layout.hpp"

/// How files and documents say angles, positions and poses, what choices are called there, and the records
/// that several of them have.
namespace truepose::record {

inline constexpr std::array kJointTypes{Named{"revolute", JointType::Revolute},
                                        Named{"prismatic", JointType::Prismatic}};
inline constexpr std::array kDeviationBases{
    Named{"sine", DeviationBasis::Sine},        Named{"cosine", DeviationBasis::Cosine},
    Named{"gravity", DeviationBasis::Gravity},  Named{"weight", DeviationBasis::Weight},
    Named{"moment-x", DeviationBasis::MomentX}, Named{"moment-y", DeviationBasis::MomentY},
    Named{"moment-z", DeviationBasis::MomentZ}, Named{"approach", DeviationBasis::Approach},
    Named{"scale", DeviationBasis::Scale},      Named{"shift-x", DeviationBasis::ShiftX},
    Named{"turn-x", DeviationBasis::TurnX},     Named{"shift-y", DeviationBasis::ShiftY},
    Named{"turn-y", DeviationBasis::TurnY},     Named{"turn-z", DeviationBasis::TurnZ}};
inline constexpr std::array kCriteria{Named{"i", DesignCriterion::I}, Named{"d", DesignCriterion::D},
                                      Named{"a", DesignCriterion::A}};

/// rad, said in deg.
struct Degrees {
  double form_of(double rad) const { return rad * kDegPerRad; }
  double value_of(double deg) const { return deg * kRadPerDeg; }
};
/// A number said in multiples of `unit`: unit_of(joint).
struct InUnit {
  double unit;
  double form_of(double value) const { return value / unit; }
  double value_of(double form) const { return form * unit; }
};
/// The sign of a joint, as a whole number.
struct Sign {
  int form_of(double sign) const { return sign < 0 ? -1 : 1; }
  double value_of(int sign) const { return sign; }
  std::string_view fault(int sign) const { return sign == 0 ? "expected -1 or 1, found 0" : ""; }
};

/// An index that counts from 1 in the text.
struct FromOne {
  int form_of(int index) const { return index + 1; }
  int value_of(int number) const { return number - 1; }
};

/// {x, y, z}
struct Xyz {
  struct Form {
    Eigen::Vector3d p;
    Range range;
  };
  Range range = kAny;

  Form form_of(const Eigen::Vector3d& p) const { return {p, range}; }
  Eigen::Vector3d value_of(const Form& form) const { return form.p; }
};
void layout_xyz(auto& io, auto& p, Range range) {
  io("x", p.x(), range);
  io("y", p.y(), range);
  io("z", p.z(), range);
}
void layout(auto& io, Is<Xyz::Form> auto& x) { layout_xyz(io, x.p, x.range); }
/// mm, within 10 m.
inline constexpr Xyz kPoint{{-10'000, 10'000}};

/// {x, y, z} of any length but zero, as a unit vector.
struct Direction : Xyz {
  constexpr Direction() : Xyz{{-1000, 1000}} {}
  Eigen::Vector3d value_of(const Form& form) const { return form.p.normalized(); }
  std::string_view fault(const Form& form) const {
    return form.p.norm() < 1e-6 ? "a direction of no length" : "";
  }
};

/// {a, b, c}: KUKA's angles, deg.
struct KukaAngles {
  struct Form {
    Eigen::Vector3d abc_deg;
  };
  Form form_of(const Eigen::Matrix3d& R) const { return {kuka_abc_deg(R)}; }
  Eigen::Matrix3d value_of(const Form& form) const {
    return pose_from_kuka(Eigen::Vector3d::Zero(), form.abc_deg).linear();
  }
};
void layout(auto& io, Is<KukaAngles::Form> auto& x) {
  io("a", x.abc_deg.x(), kDeg);
  io("b", x.abc_deg.y(), kDeg);
  io("c", x.abc_deg.z(), kDeg);
}

/// {x, y, z, a, b, c}: mm and KUKA's angles, deg.
struct KukaPose {
  struct Form {
    Eigen::Vector3d p_mm;
    KukaAngles::Form angles;
  };
  Form form_of(const Eigen::Isometry3d& X) const { return {X.translation(), {kuka_abc_deg(X.linear())}}; }
  Eigen::Isometry3d value_of(const Form& form) const {
    return pose_from_kuka(form.p_mm, form.angles.abc_deg);
  }
};
void layout(auto& io, Is<KukaPose::Form> auto& x) {
  layout_xyz(io, x.p_mm, kMm);
  layout(io, x.angles);
}

/// A verdict with its color, which follows from the findings.
struct ColoredVerdict {
  struct Form {
    VerdictColor color = VerdictColor::Green;
    std::vector<Finding> findings;
  };
  Form form_of(const CalibrationVerdict& verdict) const { return {verdict.color(), verdict.findings}; }
  CalibrationVerdict value_of(const Form& form) const { return {form.findings}; }
};

// ---- Records of several files and documents

void layout(auto& io, Is<LinkMass> auto& x) {
  io("kg", x.mass_kg, kKg);
  layout_xyz(io, x.centre_mm, kMm);
}

void layout(auto& io, Is<BasePose> auto& x) {
  layout_xyz(io, x.p_mm, kMm);
  io("rx", x.rxyz_rad.x(), kRad);
  io("ry", x.rxyz_rad.y(), kRad);
  io("rz", x.rxyz_rad.z(), kRad);
}

void layout(auto& io, Is<IdentifiedParameter> auto& x) {
  io("name", x.name);
  io("nominal", x.nominal);
  io("value", x.value);
  io("sigma", x.sigma, kNotNegative);
  io("identified", x.identified);
  io.on_read(x, [](auto& parameter) { parameter.data_share = parameter.identified ? 1 : 0; });
  io.defaulted("data_share", x.data_share, Range{0, 1});
}

void layout(auto& io, Is<Finding> auto& x) {
  io("severity", x.severity, kSeverityNames);
  io("code", x.code);
  io("sentence", x.sentence);
  io.optional("what_to_do", x.what_to_do);
}

void layout(auto& io, Is<ColoredVerdict::Form> auto& x) {
  io("color", x.color, kVerdictColorNames);
  io("findings", x.findings);
}

/// A joint in mm, deg and deg/s, up to what it carries.
void layout_in_deg(auto& io, Is<Joint> auto& x) {
  constexpr Range kAxisDeg{-100'000, 100'000};  // an axis may turn without end
  io.defaulted("type", x.type, kJointTypes);
  io("a", x.a_mm, kMm);
  io("alpha", x.alpha_rad, Degrees{}, kDeg);
  io("d", x.d_mm, kMm);
  io("theta", x.theta_rad, Degrees{}, kDeg);
  io.defaulted("beta", x.beta_rad, Degrees{}, kDeg);
  io("sign", x.sign, Sign{}, Whole{-1, 1});
  io("min", x.min, InUnit{unit_of(x)}, kAxisDeg);
  io("max", x.max, InUnit{unit_of(x)}, kAxisDeg);
  io("speed", x.speed, InUnit{unit_of(x)}, Range{0, kAxisDeg.max});
}

void layout(auto& io, Is<JointCoupling> auto& x) {
  constexpr Whole kJoint{1, kMaxJoints};
  io("joint", x.joint, FromOne{}, kJoint);
  io("to", x.to, FromOne{}, kJoint);
  io.defaulted("factor", x.factor, Range{-1000, 1000});
}

/// What couplings of an arm's joints have to be.
struct Couplings {
  std::vector<JointType> joints;

  static Couplings of(const auto& joints) {
    Couplings couplings;
    for (const auto& each : joints) couplings.joints.push_back(joint_of(each).type);
    return couplings;
  }
  std::string fault(const std::vector<JointCoupling>& coupling) const;

 private:
  static const Joint& joint_of(const Joint& joint) { return joint; }
  static const Joint& joint_of(const auto& link) { return link.joint; }
};

void layout(auto& io, Is<ArmJoint::Mass> auto& x) {
  layout_xyz(io, x.mass.centre_mm, kMm);
  io("kg", x.mass.mass_kg, kKg);
}
void layout(auto& io, Is<ArmJoint> auto& x) {
  layout_in_deg(io, x.joint);
  io.optional("mass", x.mass);
}
void layout(auto& io, Is<Arm> auto& x) {
  io("name", x.name);
  io("joints", x.joints);
  io.optional("coupling", x.coupling, Couplings::of(x.joints));
  io("flange", x.X_flange, KukaPose{});
  io.optional("payload", x.payload);
  io("gravity", x.gravity_B, Xyz{});
}

}  // namespace truepose::record
