#include "proto/control/access.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace truepose::control {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(AccessFile, KeepsWhoMayOpenSessionsAndNoToken) {
  const AccessEntries access{{entry_for_token("panel 1", Role::Operator, "secret of panel 1"),
                              entry_for_token("anna", Role::Engineer, "secret of anna")}};
  const std::string text = access_text(access);
  EXPECT_THAT(text, Not(HasSubstr("secret")));
  const auto read = read_access(text);
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(read->entries, access.entries);
  EXPECT_EQ(read->of_token("secret of panel 1")->name, "panel 1");
  EXPECT_EQ(read->of_token("secret of panel 2"), nullptr);
  EXPECT_EQ(read->of_token(""), nullptr);
  EXPECT_EQ(read->of_token("secret of anna")->role, Role::Engineer);
}

TEST(AccessFile, HashesOneTokenDifferentlyForEveryEntry) {
  const AccessEntry one = entry_for_token("a", Role::Viewer, "the same token");
  const AccessEntry other = entry_for_token("a", Role::Viewer, "the same token");
  EXPECT_NE(one.hash, other.hash);
}

TEST(TokenFile, HoldsOneWordThatIsLongEnough) {
  EXPECT_EQ(token_in(" 0123456789abcdef\r\n"), "0123456789abcdef");
  for (const char* blank : {"0123456789 abcdef", "0123456789abcdef\n0123456789abcdef"})
    EXPECT_EQ(token_in(blank).error(), "the token must be one word, without blanks inside");
  for (const std::string& length :
       {std::string{}, std::string{"\n"}, std::string(15, 'x'), std::string(1025, 'x')})
    EXPECT_EQ(token_in(length).error(), "the token must have 16..1024 characters");
}

TEST(AccessFile, NamesWhatIsWrongInIt) {
  const auto error_of = [](const std::string& text) { return read_access(text).error(); };
  EXPECT_THAT(error_of("{"), HasSubstr("byte 1"));
  EXPECT_EQ(error_of("{}"), "missing key 'access'");
  EXPECT_EQ(error_of(R"({"access": [{"name": "x", "role": "boss"}]})"),
            "access[0].role: expected one of viewer, operator, engineer, admin, found \"boss\"");
  EXPECT_EQ(error_of(R"({"access": [{"name": "x", "role": "viewer", "salt": "ab", "hash": "12"}]})"),
            "access[0].hash: expected 64 digits, 0-9 and a-f");
  const AccessEntry entry = entry_for_token("x", Role::Viewer, "secret");
  EXPECT_EQ(error_of(access_text({{entry, entry}})), "\"x\" stands there twice");
  const AccessEntry nameless = entry_for_token("\n", Role::Viewer, "secret");
  EXPECT_EQ(
      error_of(access_text({{nameless}})),
      "access[0].name: expected 1 to 64 bytes of UTF-8 without control characters, and no blank at either end");
}

TEST(AccessFile, HasNoNameThatIsNotTextOrThatTheDaemonUsesForItself) {
  for (const std::string& name : {std::string{}, std::string(65, 'x'), std::string{"M\xfcller"},
                                  std::string{"a\x1b[2J"}, std::string{"trueposed "}, std::string{" Anna"}})
    EXPECT_THAT(access_name_fault(name), HasSubstr("expected 1 to 64 bytes of UTF-8")) << name;
  for (const char* const name :
       {"token file", "Token File", "trueposed", "TRUEPOSED", "uid 0", "uid 1000", "UID 0"})
    EXPECT_EQ(access_name_fault(name), "the daemon itself uses this name; take another") << name;
  for (const char* const name : {"M\xc3\xbcller", "Anna Beer", "token", "panel 1", "uidoc"})
    EXPECT_EQ(access_name_fault(name), "") << name;
}

}  // namespace
}  // namespace truepose::control
