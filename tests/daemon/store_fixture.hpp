#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/math/angles.hpp"
#include "daemon/store/store.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {

/// A store in a file of its own.
class StoreTest : public testing::Test {
 protected:
  Store open() {
    StoreResult<Store> store = Store::open(file_);
    if (!store) throw std::runtime_error(store.error().detail);
    return std::move(*store);
  }

  std::string why_not_opened(const std::filesystem::path& file) {
    const StoreResult<Store> store = Store::open(file);
    return store ? "" : store.error().detail;
  }

  /// What another program does to the file.
  void execute(const std::string& sql) {
    sqlite3* connection = nullptr;
    ASSERT_EQ(sqlite3_open(file_.c_str(), &connection), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(connection, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(connection);
    sqlite3_close(connection);
  }

  static CampaignRecord campaign(const std::string& id) {
    return {.id = id,
            .started = "2026-08-17T10:00:00Z",
            .ended = "",
            .state = "running",
            .reason = "",
            .robot_model = "#KR210R2700_2 C4 FLR",
            .robot_serial = "4711",
            .tracker_model = "LTD840",
            .tracker_serial = "123",
            .model_id = "",
            .document = ""};
  }

  static ModelRecord model(const std::string& id, const std::string& created) {
    return {.id = id,
            .created = created,
            .campaign_id = "c1",
            .robot_serial = "4711",
            .yaml = "name: " + id + "\n",
            .validation_before_mm = 1.0 / 3,
            .validation_after_mm = 0.04,
            .active = false,
            .largest_correction_deg = 0.25};
  }

  static StoredPoint point(int pose) {
    StoredPoint p;
    p.pose = pose;
    p.purpose = static_cast<PointPurpose>(pose % 4);
    p.q_target = JointVector::LinSpaced(6, -std::numbers::pi, 1.0 / 3);
    p.q_commanded = p.q_target * 1.0000001;
    p.q_actual = JointVector::Constant(6, 1e-300);
    p.direction = {1, -1, 0, 1, 1, -1};
    p.smr = "1";
    p.p_WS_mm = Eigen::Vector3d(1234.5678901234567, -0.1, 1e-17);
    if (pose % 2 == 1) p.orientation = {rotation_zyx(0.1 * pose, -1.0 / 3, 2.0 / 3), 1e-4 / 3};
    p.std_mm = {0.001, 0.002, 0.003};
    p.temperature_c = 21.5;
    p.pressure_mbar = 1013.25;
    p.humidity_percent = 45;
    p.time = "2026-08-17T10:00:01.250Z";
    return p;
  }

  static void expect_equal(const StoredPoint& actual, const StoredPoint& expected) {
    EXPECT_EQ(actual.pose, expected.pose);
    EXPECT_EQ(actual.purpose, expected.purpose);
    EXPECT_EQ(actual.q_target, expected.q_target);
    EXPECT_EQ(actual.q_commanded, expected.q_commanded);
    EXPECT_EQ(actual.q_actual, expected.q_actual);
    EXPECT_EQ(actual.direction, expected.direction);
    EXPECT_EQ(actual.smr, expected.smr);
    EXPECT_EQ(actual.p_WS_mm, expected.p_WS_mm);
    ASSERT_EQ(actual.orientation.has_value(), expected.orientation.has_value());
    if (expected.orientation) {
      EXPECT_EQ(actual.orientation->R_WT, expected.orientation->R_WT);
      EXPECT_EQ(actual.orientation->sigma_rad, expected.orientation->sigma_rad);
    }
    EXPECT_EQ(actual.std_mm, expected.std_mm);
    EXPECT_EQ(actual.temperature_c, expected.temperature_c);
    EXPECT_EQ(actual.pressure_mbar, expected.pressure_mbar);
    EXPECT_EQ(actual.humidity_percent, expected.humidity_percent);
    EXPECT_EQ(actual.time, expected.time);
  }

  TempFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "cell.db";
};

}  // namespace truepose::daemon
