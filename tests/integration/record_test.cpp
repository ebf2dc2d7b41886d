// What becomes of the record of a daemon that runs, or ran: its audit trail and its store's log.
#include <gmock/gmock.h>
#include <signal.h>

#include <boost/json/value.hpp>
#include <filesystem>

#include "daemon/control/audit_files.hpp"
#include "tests/await.hpp"
#include "tests/integration/live_cell.hpp"

namespace truepose {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class TheRecord : public testing::Test {
 protected:
  TheRecord() : cell_{{.patient = true}} {
    cell_.start_daemon();
    const Finished made = small_campaign(cell_);
    EXPECT_EQ(made.exit_code, 0) << made.err;
  }
  Finished verify(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"audit", "verify", "--cell", cell_.cell_file()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program("truepose", arguments);
  }
  void stop() {
    cell_.daemon().terminate();
    EXPECT_EQ(cell_.daemon().wait(), 0);
    log_ += cell_.daemon().errors();
  }
  void acknowledge() {
    const Finished done = cell_.truepose({"audit", "acknowledge", "--name", "Anna Beer"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
  }
  fs::path trail() const { return daemon::audit_file_of(cell_.store_file()); }

  LiveCell cell_;
  std::string log_;
};

TEST_F(TheRecord, IsMissedAfterARestartUntilAnAdminAcknowledgesThat) {
  EXPECT_EQ(verify().exit_code, 0);
  stop();
  const fs::path log = cell_.write("log", log_);
  EXPECT_EQ(verify({"--journal", log}).exit_code, 0);
  fs::remove(trail());
  fs::remove(daemon::audit_head_of(trail()));
  EXPECT_THAT(verify().err, HasSubstr("it is missing, and had"));
  for (int restarts = 0; restarts < 2; ++restarts) {
    cell_.start_daemon();
    EXPECT_THAT(cell_.truepose({"status"}).out,
                AllOf(HasSubstr("E_AUDIT"), HasSubstr("it is missing, and had")));
    EXPECT_EQ(verify().exit_code, 1);
    if (restarts == 0) stop();
  }
  acknowledge();
  EXPECT_THAT(cell_.truepose({"status"}).out, Not(HasSubstr("E_AUDIT")));
  const Finished now = verify({"--journal", log});
  EXPECT_EQ(now.exit_code, 0) << now.err;
  EXPECT_THAT(now.out, HasSubstr("acknowledged by Anna Beer"));
}

TEST_F(TheRecord, IsMissedUnderTheDaemonAndNothingGoesOnOffRecord) {
  const auto faults = [this] { return cell_.truepose({"status"}).out; };
  fs::remove(trail());
  fs::remove(daemon::audit_head_of(trail()));
  await("it is missed", [&] { return faults().find("E_STORE") != std::string::npos; });
  EXPECT_THAT(cell_.truepose({"stream", "start"}).err, HasSubstr("was deleted"));
  acknowledge();
  EXPECT_EQ(cell_.truepose({"acknowledge"}).exit_code, 0);
  EXPECT_THAT(faults(), AllOf(Not(HasSubstr("E_STORE")), Not(HasSubstr("E_AUDIT"))));
  const Finished now = verify();
  EXPECT_EQ(now.exit_code, 0) << now.err;
}

TEST_F(TheRecord, OfTheStoreOutlivesItsLogWhereThatIsDeletedUnderTheDaemonAndItIsKilled) {
  for (const char* log : {"-wal", "-shm"}) fs::remove(cell_.store_file().string() + log);
  await("it is missed",
        [&] { return cell_.truepose({"status"}).out.find("-wal: was deleted") != std::string::npos; });
  cell_.daemon().send(SIGKILL);
  cell_.daemon().wait();
  cell_.start_daemon();
  EXPECT_THAT(cell_.truepose({"campaign", "list"}).out, HasSubstr("done"));
  EXPECT_THAT(cell_.truepose({"model", "list"}).out, HasSubstr("active"));
}

}  // namespace
}  // namespace truepose
