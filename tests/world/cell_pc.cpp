#include "tests/world/cell_pc.hpp"

#include <algorithm>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <utility>

#include "daemon/daemon.hpp"
#include "daemon/machine.hpp"
#include "daemon/threads/signal.hpp"
#include "daemon/threads/worker.hpp"
#include "drivers/net/spawn.hpp"
#include "tests/daemon_heap.hpp"

namespace truepose::world {

namespace asio = boost::asio;

namespace {

/// Does its jobs on the world's thread, each after the time that a real one may take.
class WorldWorker final : public daemon::Worker {
 public:
  WorldWorker(drivers::Clock& clock, std::uint64_t seed, drivers::Duration longest, const double& slowness)
      : clock_{clock}, random_{seed}, longest_{longest}, slowness_{slowness} {}

  asio::awaitable<void> run(std::function<void()> job) override {
    const auto takes =
        std::chrono::duration_cast<drivers::Duration>(longest_ * slowness_ * random_.uniform());
    free_ = std::max(free_, clock_.now()) + takes;
    // A cancelled caller still waits for its job.
    auto token = asio::bind_cancellation_slot(asio::cancellation_slot{}, asio::use_awaitable);
    const auto executor = co_await asio::this_coro::executor;
    co_await asio::co_spawn(executor, carry_out(std::move(job), free_), token);
  }

 private:
  asio::awaitable<void> carry_out(std::function<void()> job, drivers::TimePoint end) {
    co_await clock_.sleep_until(end);
    job();
  }

  drivers::Clock& clock_;
  Random random_;
  drivers::Duration longest_;
  const double& slowness_;
  drivers::TimePoint free_{};
};

/// Of a process that can be killed: all that runs or waits in it is gone at once, and nothing more happens.
class EventLoop final : public asio::io_context {
 public:
  EventLoop() : io_context{1} {}
  void kill() { shutdown(); }
};

constexpr std::chrono::milliseconds kCommit{20};
constexpr std::chrono::seconds kIdentification{5};
constexpr std::chrono::milliseconds kRecording{200};

}  // namespace

/// One process of the daemon.
struct CellPc::Life {
  Life(World& world, const config::CellConfig& config, const std::filesystem::path& runtime,
       drivers::WallClock wall_clock, const double& slowness)
      : store_thread{world.clock, world.random.next(), kCommit, slowness},
        compute_thread{world.clock, world.random.next(), kIdentification, slowness},
        recorder_thread{world.clock, world.random.next(), kRecording, slowness} {
    daemon = daemon::Daemon::start({.io = loop.get_executor(),
                                    .clock = world.clock,
                                    .store_thread = store_thread,
                                    .compute_thread = compute_thread,
                                    .recorder_thread = recorder_thread,
                                    .wall_clock = std::move(wall_clock),
                                    .network = world.network.network(),
                                    .random = world.random_bytes(),
                                    .start_rsi_link = world.rsi.pc(loop.get_executor())},
                                   config, runtime);
    net::spawn(loop.get_executor(), daemon->live(end.wait()), [this](std::exception_ptr failed) {
      net::rethrow(std::move(failed));
      ended = true;
    });
  }
  // As the members of a process that ends, but for those of a killed one.
  ~Life() {
    if (!ended) loop.kill();
    daemon.reset();
  }

  EventLoop loop;
  WorldWorker store_thread, compute_thread, recorder_thread;
  daemon::Signal end;
  bool ended = false;
  std::unique_ptr<daemon::Daemon> daemon;
};

CellPc::CellPc(World& world, test::FailingDisk& disk, config::CellConfig config,
               std::filesystem::path runtime)
    : world_{world},
      disk_{disk},
      config_{std::move(config)},
      runtime_{std::move(runtime)},
      files_{".", runtime_, world.random.next(), disk} {
  std::filesystem::create_directories(runtime_);
  world_.add(*this);
}

CellPc::~CellPc() {
  kill();
  world_.remove(*this);
}

void CellPc::start() {
  const auto wall_clock = [this] {
    const auto time = world_.clock.now().time_since_epoch() + wall_clock_error;
    return std::chrono::system_clock::time_point{
        std::chrono::duration_cast<std::chrono::system_clock::duration>(time)};
  };
  read_ = config_;
  started_ = world_.clock.now();
  stopped_.reset();
  const AllocatesFor daemon{AllocatesFor::Daemon};
  life_ = std::make_unique<Life>(world_, read_, runtime_, wall_clock, slowness);
}

void CellPc::stop() {
  if (!life_) return;
  if (!stopped_) stopped_ = world_.clock.now();
  life_->end.notify();
}

void CellPc::kill() {
  disk_.cut_power();  // what its destructors would write
  life_.reset();
  disk_.restore_process();
}

void CellPc::lose_power() {
  disk_.cut_power();
  life_.reset();
  files_.lose_power();
  disk_.restore_power();
  std::filesystem::create_directories(runtime_);
}

bool CellPc::poll() {
  if (!life_ || stalls()) return false;
  const AllocatesFor daemon{AllocatesFor::Daemon};
  life_->loop.restart();
  const bool ran = life_->loop.poll() != 0;
  if (life_->ended && life_->loop.stopped()) {
    life_->daemon->settle();
    life_.reset();
  }
  return ran;
}

}  // namespace truepose::world
