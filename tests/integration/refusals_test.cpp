#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "tests/await.hpp"
#include "tests/certificates.hpp"
#include "tests/integration/live_cell.hpp"

namespace truepose {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Finished run_daemon(const LiveCell& cell, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"--config", cell.cell_file()});
  return run_program("trueposed", more);
}

void expect_one_line(const Finished& refused, int exit_code) {
  EXPECT_EQ(refused.exit_code, exit_code) << refused.err;
  EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
  EXPECT_EQ(refused.out, "");
}

TEST(TheDaemon, NamesWhoHoldsItsRsiPort) {
  LiveCell cell;
  cell.start_daemon();
  const TempFolder
      other;  // of a second cell that was copied from this one, with a store and a folder of its own
  std::string copied = text_of(cell.cell_file());
  copied.insert(copied.find("demo.sqlite"), other.path().string() + "/");
  copied.insert(copied.find("runtime: run") + 9, other.path().string() + "/");
  const Finished refused = run_program("trueposed", {"--config", cell.write("copied.yaml", copied)});
  expect_one_line(refused, 3);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("RSI address"),
                    HasSubstr("trueposed (process " + std::to_string(cell.daemon().pid()) + ")")));
}

TEST(TheDaemon, LeavesAFolderOfRecordingsToTheDaemonThatHasIt) {
  LiveCell cell{{.cell = {{"#folder: recordings", "folder: recordings"}}}};
  cell.start_daemon();
  std::string copied = text_of(cell.cell_file());
  copied.replace(copied.find("demo.sqlite"), 11, "other.sqlite");
  copied.replace(copied.find("runtime: run"), 12, "runtime: run2");
  const Finished refused = run_program("trueposed", {"--config", cell.write("copied.yaml", copied)});
  expect_one_line(refused, 3);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("the recordings folder"), HasSubstr("is in use by trueposed (process")));
}

TEST(TheDaemon, EndsThoughNobodyReadsItsLog) {
  LiveCell cell;
  const std::filesystem::path log = cell.folder() / "log";
  ASSERT_EQ(::mkfifo(log.c_str(), 0600), 0);
  const int reader = ::open(log.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  const std::string page(4096, '.');
  while (::write(reader, page.data(), page.size()) > 0) {
  }
  const pid_t daemon = ::fork();
  if (daemon == 0) {
    const int full = ::open(log.c_str(), O_WRONLY);
    ::dup2(full, STDERR_FILENO);
    const std::string program = std::filesystem::path{TRUEPOSE_BIN_DIR} / "trueposed",
                      file = cell.cell_file();
    ::execl(program.c_str(), program.c_str(), "--config", file.c_str(), nullptr);
    ::_exit(127);
  }
  await("it serves", [&] { return std::filesystem::exists(cell.folder() / "run/control.sock"); });
  await("its client is answered", [&] {
    return run_program("truepose", {"status", "--daemon", cell.folder() / "run/control.sock"}).exit_code == 0;
  });
  ::kill(daemon, SIGTERM);
  int status = 0;
  await("it ends", [&] { return ::waitpid(daemon, &status, WNOHANG) == daemon; });
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  ::close(reader);
}

TEST(TheDaemon, LeavesAStoreToTheDaemonThatHasIt) {
  LiveCell cell;
  cell.start_daemon();
  const Finished refused = run_daemon(cell);
  expect_one_line(refused, 3);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("the store"), HasSubstr("demo.sqlite is in use by trueposed (process " +
                                                      std::to_string(cell.daemon().pid()) + ")")));
}

TEST(TheDaemon, WaitsForAnAddressThatIsNotThereYetRatherThanForAPerson) {
  const LiveCell cell{{.cell = {{"listen: 127.0.0.1:", "listen: 192.0.2.1:"}}}};
  const Finished refused = run_daemon(cell);
  expect_one_line(refused, 3);
  EXPECT_THAT(refused.err, HasSubstr("192.0.2.1"));
}

TEST(TheDaemon, TellsTheServiceManagerThatItLivesAsOftenAsItIsAsked) {
  LiveCell cell;
  cell.start_daemon({"WATCHDOG_USEC=400000"});
  for (int times = 0; times < 3; ++times) EXPECT_TRUE(cell.daemon_tells("WATCHDOG=1"));
}

// Nobody might read what it tells, and a full socket would stop the thread that writes.
TEST(TheDaemon, TellsNothingOfItsLifeToAServiceManagerThatDoesNotAsk) {
  LiveCell cell;
  cell.start_daemon();
  EXPECT_TRUE(cell.client().call("cell.status", {}));
  cell.daemon().send(SIGTERM);
  EXPECT_FALSE(cell.daemon_tells("WATCHDOG=1"));
  EXPECT_EQ(cell.daemon().wait(), 0);
}

TEST(TheDaemon, EndsWithTheSameCodeWhetherItStartsOrChecksItsFiles) {
  const LiveCell cell{{.cell = {{"  #tls:", "  tls:"},
                                {"  #  listen: 0.0.0.0:7211", "    listen: 127.0.0.1:0"},
                                {"  #  certificate: tls/", "    certificate: "},
                                {"  #  key: tls/", "    key: "}}}};
  const Certificates certificates{cell.folder()};
  certificates.make("daemon");
  certificates.end_in("daemon", -1);
  const auto ends = [&cell] {
    return std::pair{run_daemon(cell).exit_code, run_daemon(cell, {"--check"}).exit_code};
  };
  EXPECT_EQ(ends(), (std::pair{3, 3}))
      << "a certificate that has expired: by the clock, which may be put right";
  std::filesystem::remove(cell.token_file());
  EXPECT_EQ(ends(), (std::pair{2, 2})) << "a further mistake, which the operator has to fix";
}

}  // namespace
}  // namespace truepose
