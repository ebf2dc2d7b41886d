#include "proto/record/forms.hpp"

#include "proto/record/io.hpp"

namespace truepose::record {

void layout_xyz(Io& io, Eigen::Vector3d& p, Range range) {
  io("x", p.x(), range);
  io("y", p.y(), range);
  io("z", p.z(), range);
}

void layout(Io& io, KukaAngles::Form& x) {
  io("a", x.abc_deg.x(), kDeg);
  io("b", x.abc_deg.y(), kDeg);
  io("c", x.abc_deg.z(), kDeg);
}

void layout(Io& io, KukaPose::Form& x) {
  layout_xyz(io, x.p_mm, kMm);
  layout(io, x.angles);
}

void layout(Io& io, LinkMass& x) {
  io.record("mass", "");
  io("kg", x.mass_kg, kKg);
  layout_xyz(io, x.centre_mm, kMm);
}

void layout(Io& io, BasePose& x) {
  io.record("pose", "mm and rad; R = Rz(rz) Ry(ry) Rx(rx)");
  layout_xyz(io, x.p_mm, kMm);
  io("rx", x.rxyz_rad.x(), kRad);
  io("ry", x.rxyz_rad.y(), kRad);
  io("rz", x.rxyz_rad.z(), kRad);
}

void layout(Io& io, IdentifiedParameter& x) {
  io.record("parameter",
            "mm or rad; data_share: 1 where the data alone determine it, less where the prior does");
  io("name", x.name);
  io("nominal", x.nominal);
  io("value", x.value);
  io("sigma", x.sigma, kNotNegative);
  io("identified", x.identified);
  io.on_read(x, [](auto& parameter) { parameter.data_share = parameter.identified ? 1 : 0; });
  io.defaulted("data_share", x.data_share, Range{0, 1});
}

void layout(Io& io, Finding& x) {
  io("severity", x.severity, kSeverityNames);
  io("code", x.code);
  io("sentence", x.sentence);
  io.optional("what_to_do", x.what_to_do);
}

void layout(Io& io, ColoredVerdict::Form& x) {
  io("color", x.color, kVerdictColorNames);
  io("findings", x.findings);
}

void layout_in_deg(Io& io, Joint& x) {
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

void layout(Io& io, JointCoupling& x) {
  constexpr Whole kJoint{1, kMaxJoints};
  io("joint", x.joint, FromOne{}, kJoint);
  io("to", x.to, FromOne{}, kJoint);
  io.defaulted("factor", x.factor, Range{-1000, 1000});
}

void layout(Io& io, ArmJoint::Mass& x) {
  io.record("mass", "");
  layout_xyz(io, x.mass.centre_mm, kMm);
  io("kg", x.mass.mass_kg, kKg);
}

void layout(Io& io, ArmJoint& x) {
  io.record("joint", "as in a robot file: mm, deg, deg/s");
  layout_in_deg(io, x.joint);
  io.optional("mass", x.mass);
}

void layout(Io& io, Arm& x) {
  io("name", x.name);
  io("joints", x.joints);
  io.about("as in a robot file: in the chain of links the joint stands at its q + factor * q of joint `to`")
      .optional("coupling", x.coupling, Couplings::of(x.joints));
  io("flange", x.X_flange, KukaPose{});
  io.optional("payload", x.payload);
  io("gravity", x.gravity_B, Xyz{});
}

}  // namespace truepose::record
