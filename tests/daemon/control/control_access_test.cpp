#include <gmock/gmock.h>

#include <boost/json/parse.hpp>

#include "daemon/control/access_list.hpp"
#include "proto/control/schema.hpp"
#include "proto/rpc/methods.hpp"
#include "tests/daemon/control_fixture.hpp"
#include "tests/no_more_files.hpp"

namespace truepose::daemon {
namespace {

using namespace test;
using control::AccessEntries;
using control::Role;
using testing::HasSubstr;

/// Answers every method of the schema that is not the server's own.
class WillingCell : public CellService {
 public:
  std::vector<std::string> methods() const override {
    std::vector<std::string> methods = rpc::method_names();
    std::erase_if(methods, [](const std::string& method) {
      return method.starts_with("session.") || method.starts_with("events.") || method == "system.info";
    });
    return methods;
  }
  asio::awaitable<std::expected<json::value, control::RpcError>> call(std::string method, json::object,
                                                                      std::string) override {
    co_return json::object{{"method", method}};
  }
  asio::awaitable<std::expected<json::value, control::RpcError>> pause(std::string, std::string) override {
    co_return json::object{};
  }
  void stand(bool stands, const Fault& fault) override {
    const std::string code{kind_of(fault.code).code};
    standing.erase(code);
    if (stands) standing[code] = fault.text;
  }
  std::map<std::string, std::string> standing;
};

std::string token_of(Role role) { return "token of one who is " + std::string{control::name(role)}; }

AccessEntries one_of_each_role() {
  AccessEntries access;
  for (const auto& [name, role] : control::kRoles)
    access.entries.push_back(control::entry_for_token(std::string{name}, role, token_of(role)));
  return access;
}

const std::map<std::string, Role> kRoleNames{{"viewer", Role::Viewer},
                                             {"operator", Role::Operator},
                                             {"engineer", Role::Engineer},
                                             {"admin", Role::Admin}};

/// x-role of a method; empty where it has none.
std::string role_in_schema(const std::string& method) {
  const json::value schema = json::parse(std::string{control::openrpc_text()});
  for (const json::value& each : schema.at("methods").as_array()) {
    if (each.at("name").as_string() != method) continue;
    const json::value* const role = each.as_object().if_contains("x-role");
    return role ? role->as_string().c_str() : "";
  }
  return "";
}

class ControlAccess : public ControlServerTest {
 protected:
  ControlAccess() { served_ = &willing_; }
  WillingCell willing_;
};

TEST_F(ControlAccess, EveryMethodThatIsServedHasItsRoleInTheSchema) {
  serve();
  for (const std::string& method : server_->methods()) {
    if (method == "rpc.discover") continue;
    EXPECT_TRUE(kRoleNames.contains(role_in_schema(method))) << method << ": " << role_in_schema(method);
  }
}

TEST_F(ControlAccess, LetsEveryRoleCallItsMethodsAndNoOthers) {
  write_access(one_of_each_role());
  const auto port = serve();
  for (const auto& [name, role] : control::kRoles) {
    Client client{port};
    ASSERT_EQ(Client::code_of(client.hello(token_of(role))), 0) << name;
    for (const std::string& method : server_->methods()) {
      if (method.starts_with("session.")) continue;
      const bool allowed = method == "rpc.discover" || kRoleNames.at(role_in_schema(method)) <= role;
      EXPECT_EQ(client.code(method) == -32002, !allowed) << name << " calls " << method;
    }
  }
}

TEST_F(ControlAccess, SaysWhoOneIsAndWhichRoleAMethodNeeds) {
  write_access(one_of_each_role());
  Client viewer{serve()};
  const Reply hello = viewer.hello(token_of(Role::Viewer));
  EXPECT_EQ(hello.result->at("name").as_string(), "viewer");
  EXPECT_EQ(hello.result->at("role").as_string(), "viewer");
  EXPECT_EQ(viewer.call("stream.stop").result.error().message,
            "stream.stop needs the role operator; viewer is viewer");
}

TEST_F(ControlAccess, TheTokenFileAndTheUnixSocketAreAdmin) {
  const auto port = serve();
  EXPECT_EQ(Client{port}.hello().result->at("role").as_string(), "admin");
  const Reply local = Client{socket()}.call("session.hello", {{"protocol", 1}});
  EXPECT_EQ(local.result->at("role").as_string(), "admin");
  EXPECT_EQ(local.result->at("name").as_string(), "uid " + std::to_string(::geteuid()));
}

TEST_F(ControlAccess, LetsInWhoWasAddedSinceTheStart) {
  const auto port = serve();
  EXPECT_EQ(Client::code_of(Client{port}.hello(token_of(Role::Viewer))), -32001);
  write_access(one_of_each_role());
  EXPECT_EQ(Client::code_of(Client{port}.hello(token_of(Role::Viewer))), 0);
}

TEST_F(ControlAccess, ClosesTheSessionOfWhoIsRevokedAndNoOther) {
  AccessEntries access = one_of_each_role();
  write_access(access);
  const auto port = serve();
  Client revoked{port}, other{port};
  revoked.hello(token_of(Role::Viewer));
  revoked.call("events.subscribe");
  other.hello(token_of(Role::Operator));
  access.entries.erase(access.entries.begin());
  write_access(access);
  advance(2s);
  EXPECT_EQ(revoked.reply().result.error().message, "closed: the access of viewer was changed or revoked");
  EXPECT_TRUE(revoked.closed());
  EXPECT_EQ(Client::code_of(Client{port}.hello(token_of(Role::Viewer))), -32001);
  EXPECT_EQ(other.code("cell.status"), 0);
}

TEST_F(ControlAccess, CarriesOutNothingMoreForWhoWasRevokedAMomentAgo) {
  write_access(one_of_each_role());
  Client revoked{serve()};
  revoked.hello(token_of(Role::Operator));
  EXPECT_EQ(revoked.code("control.acquire"), 0);
  write_access({});
  revoked.send(control::encode_request(7, "control.release", {}));
  const Reply reply = revoked.reply();
  ASSERT_FALSE(reply.result) << "it was carried out";
  EXPECT_EQ(reply.result.error().message, "closed: the access of operator was changed or revoked");
  EXPECT_TRUE(revoked.closed());
}

TEST_F(ControlAccess, KeepsWhatItKnewWhereTheFileCannotBeUsed) {
  write_access(one_of_each_role());
  const auto port = serve();
  folder_.write("access", "{");
  EXPECT_EQ(Client::code_of(Client{port}.hello(token_of(Role::Viewer))), 0);
}

TEST_F(ControlAccess, RevokesAsSoonAsTheFileCanBeReadAgain) {
  write_access(one_of_each_role());
  AccessList list{access_file()};
  ASSERT_TRUE(list.refresh().value());
  write_access({});
  {
    const NoMoreFiles none;
    EXPECT_THAT(list.refresh().error(), HasSubstr("cannot be read: Too many open files"));
    EXPECT_FALSE(list.refresh().value()) << "reported twice";
    EXPECT_FALSE(list.entries().entries.empty());
  }
  EXPECT_TRUE(list.refresh().value());
  EXPECT_TRUE(list.entries().entries.empty());
  EXPECT_FALSE(list.refresh().value());
}

TEST_F(ControlAccess, LetsInTheTokenFileAloneWhileTheAccessFileCannotBeUsed) {
  write_access(one_of_each_role());
  fs::permissions(access_file(), fs::perms::others_read, fs::perm_options::add);
  const auto port = serve();
  EXPECT_EQ(Client::code_of(Client{port}.hello(token_of(Role::Viewer))), -32001);
  EXPECT_EQ(Client::code_of(Client{port}.hello()), 0);
  on_loop([this] { EXPECT_THAT(willing_.standing.at("E_ACCESS"), HasSubstr("chmod 600")); });
  write_access(one_of_each_role());
  EXPECT_EQ(Client::code_of(Client{port}.hello(token_of(Role::Viewer))), 0);
  on_loop([this] { EXPECT_FALSE(willing_.standing.contains("E_ACCESS")); });
}

}  // namespace
}  // namespace truepose::daemon
