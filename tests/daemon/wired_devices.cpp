#include "tests/daemon/wired_devices.hpp"

#include <algorithm>
#include <array>
#include <chrono>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using namespace std::chrono_literals;

namespace {

/// The next document of a client; none where the client has gone.
asio::awaitable<std::optional<eki::ToController>> next_document(drivers::MemoryStream& client,
                                                                eki::DocumentSplitter& splitter) {
  for (;;) {
    const auto document = splitter.next();
    if (document.value()) co_return eki::decode_to_controller(**document).value();
    std::array<char, 512> bytes;
    const auto [error, size] = co_await client.read(bytes);
    if (error) co_return std::nullopt;
    splitter.feed({bytes.data(), size});
  }
}

eki::Axes axes_of(const JointVector& q) {
  eki::Axes axes{};
  std::ranges::copy(q, axes.begin());
  return axes;
}

}  // namespace

WiredController::WiredController(drivers::MemoryNetwork& network, drivers::MockCell& cell) : cell_{cell} {
  network.listen(kMotion, [this](Client client) { return serve_motion(std::move(client)); });
  network.listen(kState, [this](Client client) { return serve_state(std::move(client)); });
}

asio::awaitable<void> WiredController::serve_motion(Client client) {
  while (serving_) co_await served_.wait();
  serving_ = true;
  const eki::Hello hello{
      .model = cell_.options().robot_model, .serial = "210001", .kss_version = "KSS 8.6.11"};
  const std::string greeting = eki::encode(hello);
  co_await client->write(greeting);
  eki::DocumentSplitter splitter;
  for (;;) {
    const auto message = co_await next_document(*client, splitter);
    if (!message) break;
    const auto& command = std::get<eki::Command>(*message);
    if (command.id == last_.id) {
      co_await acknowledge(client, last_.state, static_cast<eki::AckError>(last_.error));
    } else {
      co_await carry_out(client, command);
    }
  }
  serving_ = false;
  served_.notify();
}

asio::awaitable<void> WiredController::carry_out(Client client, eki::Command command) {
  last_.id = command.id;
  if (stopped_) {
    co_await acknowledge(client, eki::AckState::Rejected, eki::AckError::Stopped);
    co_return;
  }
  const int stops = stops_;
  co_await acknowledge(client, eki::AckState::Moving, eki::AckError::None);
  if (stops_ != stops) {
    // An interrupt of the program: what was asked for before a stop is not driven to behind it.
    co_await acknowledge(client, eki::AckState::Aborted, eki::AckError::Stopped);
    co_return;
  }
  ++motions;
  const JointVector q = Eigen::Map<const JointVector>(command.axes_rad.data(), 6);
  cell_.start_motion(q, command.velocity_percent);
  const drivers::TimePoint end = cell_.motion_ends() + std::chrono::milliseconds{command.settle_ms};
  while (cell_.clock().now() < end) {
    const drivers::TimePoint next = std::min(end, cell_.clock().now() + 20ms);
    co_await cell_.clock().sleep_until(next);
    const bool lost = !client->has_client();
    if (!lost && !stopped_) continue;
    cell_.stop_motion();
    co_await acknowledge(client, eki::AckState::Aborted,
                         lost ? eki::AckError::LinkLost : eki::AckError::Stopped);
    co_return;
  }
  co_await acknowledge(client, eki::AckState::InPosition, eki::AckError::None);
}

asio::awaitable<void> WiredController::acknowledge(Client client, eki::AckState state, eki::AckError error) {
  last_ = {last_.id, state, static_cast<int>(error), axes_of(cell_.q())};
  const std::string text = eki::encode(last_);
  co_await client->write(text);
}

asio::awaitable<void> WiredController::serve_state(Client client) {
  eki::DocumentSplitter splitter;
  for (;;) {
    const auto message = co_await next_document(*client, splitter);
    if (!message) co_return;
    const auto& control = std::get<eki::Control>(*message);
    if (control.op == eki::ControlOp::Stop) {
      stopped_ = true;
      ++stops_;
    }
    if (control.op == eki::ControlOp::ReleaseStop) stopped_ = false;
    const std::string text = eki::encode(state_for(control));
    co_await client->write(text);
  }
}

eki::State WiredController::state_for(const eki::Control& control) const {
  eki::State state;
  state.id = control.id;
  state.mode = eki::OperatingMode::Ext;
  state.program = eki::ProgramState::Active;
  state.drives_ready = state.no_emergency_stop = state.gate_closed = true;
  state.in_position = !cell_.moving();
  state.axes_rad = axes_of(cell_.q());
  const Eigen::Isometry3d X_BF = forward_kinematics(cell_.options().nominal, cell_.q());
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X_BF.linear());
  std::ranges::copy(X_BF.translation(), state.pose.begin());
  std::ranges::copy(abc_deg, state.pose.begin() + 3);
  return state;
}

WiredBridge::WiredBridge(asio::io_context& io, drivers::MemoryNetwork& network, drivers::MockCell& cell)
    : cell_{cell}, protocol_{io, network, cell.clock()} {
  protocol_.script("measure", [this](std::int64_t id, const bridge::Request& request) {
    measure(id, std::get<bridge::DoMeasure>(request).time);
  });
}

void WiredBridge::measure(std::int64_t id, std::chrono::milliseconds time) {
  protocol_.later(time, [this, id, time, connection = protocol_.connections] {
    if (connection != protocol_.connections) return;  // who asked has gone
    const TrackerNoiseModel& noise = cell_.options().noise;
    const bridge::Measured result{.p_W_mm = cell_.reading_mm(cell_.p_WS_mm(), 1, noise),
                                  .std_mm = Eigen::Vector3d::Constant(noise.range_mm),
                                  .covariance_mm2 = {},
                                  .averaged = time,
                                  .air = {20, 1013, 50}};
    protocol_.answer(id, result);
  });
}

WiredTracker::WiredTracker(asio::io_context& io, drivers::MemoryNetwork& network, drivers::MockCell& cell)
    : cell_{cell}, protocol_{io} {
  protocol_.script(emscon::CommandCode::StartMeasurement, [this] {
    protocol_.answer(emscon::CommandCode::StartMeasurement);
    asked_to_measure_ = true;
  });
  network.listen(kPort,
                 [this](std::shared_ptr<drivers::MemoryStream> client) { return serve(std::move(client)); });
}

asio::awaitable<void> WiredTracker::serve(std::shared_ptr<drivers::MemoryStream> client) {
  emscon::PacketSplitter splitter;
  std::array<char, 512> bytes;
  for (;;) {
    const auto [error, size] = co_await client->read(bytes);
    if (error) co_return;
    splitter.push({reinterpret_cast<const std::uint8_t*>(bytes.data()), size});
    drivers::FakeTracker::Bytes answers = protocol_.answers_to(splitter);
    if (std::exchange(asked_to_measure_, false)) {
      const drivers::TimePoint done = cell_.clock().now() + 2s;
      co_await cell_.clock().sleep_until(done);
      const TrackerNoiseModel& noise = cell_.options().noise;
      const Eigen::Vector3d p_mm = cell_.reading_mm(cell_.p_WS_mm(), 1, noise);
      protocol_.result.v = {p_mm.x(), p_mm.y(), p_mm.z()};
      protocol_.result.std.fill(noise.range_mm);
      protocol_.result.environment = {20, 1013, 50};
      std::ranges::copy(emscon::encode(protocol_.result), std::back_inserter(answers));
    }
    co_await client->write({reinterpret_cast<const char*>(answers.data()), answers.size()});
  }
}

}  // namespace truepose::daemon
