#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/arm/joint_units.hpp"
#include "core/calibrate/calibration.hpp"
#include "core/choices.hpp"
#include "core/math/angles.hpp"
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
void layout_xyz(Io& io, Eigen::Vector3d& p, Range range);
inline void layout(Io& io, Xyz::Form& x) { layout_xyz(io, x.p, x.range); }
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
void layout(Io& io, KukaAngles::Form& x);

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
void layout(Io& io, KukaPose::Form& x);

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

void layout(Io& io, LinkMass& x);

void layout(Io& io, BasePose& x);

void layout(Io& io, IdentifiedParameter& x);

void layout(Io& io, Finding& x);

void layout(Io& io, ColoredVerdict::Form& x);

/// A joint in mm, deg and deg/s, up to what it carries.
void layout_in_deg(Io& io, Joint& x);

void layout(Io& io, JointCoupling& x);

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

void layout(Io& io, ArmJoint::Mass& x);
void layout(Io& io, ArmJoint& x);
void layout(Io& io, Arm& x);

}  // namespace truepose::record
