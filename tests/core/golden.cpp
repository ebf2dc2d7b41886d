#include "tests/core/golden.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "core/math/angles.hpp"

namespace truepose::golden {

boost::json::object load(const std::string& name) {
  std::ifstream in{std::string{TRUEPOSE_SOURCE_DIR} + "/tests/golden/" + name + ".json"};
  if (!in) throw std::runtime_error("tests/golden/" + name + ".json cannot be read");
  std::stringstream text;
  text << in.rdbuf();
  return boost::json::parse(text.str()).as_object();
}

double number(const boost::json::value& value) { return value.to_number<double>(); }

Eigen::VectorXd vector(const boost::json::value& value) {
  const auto& items = value.as_array();
  Eigen::VectorXd v(static_cast<Eigen::Index>(items.size()));
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = number(items[static_cast<std::size_t>(i)]);
  return v;
}

Eigen::MatrixXd matrix(const boost::json::value& value) {
  const auto& rows = value.as_array();
  Eigen::MatrixXd m(static_cast<Eigen::Index>(rows.size()),
                    static_cast<Eigen::Index>(rows.at(0).as_array().size()));
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    m.row(i) = vector(rows[static_cast<std::size_t>(i)]).transpose();
  return m;
}

RobotModel robot(const boost::json::value& links, const boost::json::value& sign) {
  constexpr std::array kMinDeg{-185., -140., -120., -350., -125., -350.};
  constexpr std::array kMaxDeg{185., -5., 168., 350., 125., 350.};
  const Eigen::MatrixXd rows = matrix(links);
  RobotModel model;
  model.name = "KR 210 R2700-2";
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    model.joints.push_back({.a_mm = rows(i, 0),
                            .alpha_rad = rows(i, 1),
                            .d_mm = rows(i, 2),
                            .theta_rad = rows(i, 3),
                            .beta_rad = rows(i, 4),
                            .sign = number(sign.as_array()[k]),
                            .min = kMinDeg.at(k) * kRadPerDeg,
                            .max = kMaxDeg.at(k) * kRadPerDeg,
                            .speed = 110 * kRadPerDeg});
  }
  return model;
}

CalibratedCell cell(const RobotModel& robot, const boost::json::value& base, const boost::json::value& tool) {
  const Eigen::VectorXd b = vector(base);
  return {robot, {b.head<3>(), b.tail<3>()}, {{"1", vector(tool)}}};
}

DataSet data_set(const boost::json::object& identify, std::size_t index, const char* validation) {
  const auto& set = identify.at("datasets").as_array()[index];
  DataSet out{set.at("expected").as_object(), {.smr_names = {"1"}, .points = {}}};
  const auto add = [&](const char* part, PoseSet purpose, const char* key) {
    for (const auto& item : set.at(part).as_array()) {
      out.data.points.push_back({.q = vector(item.at("q")), .p_WS_mm = vector(item.at(key)), .set = purpose});
    }
  };
  add("identification", PoseSet::Identify, "measured");
  add("validation", PoseSet::Validate, validation);
  return out;
}

RobotModel nominal(const boost::json::object& identify) {
  return robot(identify.at("nominal_links"), identify.at("sign"));
}

}  // namespace truepose::golden
