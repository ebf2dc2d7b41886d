// Tokens, aggregates and the rewriting of numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "proto/krl/places.hpp"
#include "proto/krl/position.hpp"
#include "proto/krl/rewrite.hpp"

namespace truepose::krl {
namespace {

using testing::ElementsAre;

std::vector<std::string> words(std::string_view text) {
  StatementReader reader(text);
  std::vector<std::string> result;
  while (true) {
    const auto statement = reader.next();
    if (!statement) return {"fault at " + std::to_string(statement.error().at)};
    if (statement->empty()) return result;
    for (const Token& token : *statement) result.emplace_back(token.text);
    result.emplace_back("|");
  }
}

/// The tokens of one statement.
struct Statement {
  explicit Statement(std::string text_in)
      : text(std::move(text_in)), reader(text), tokens(reader.next().value()) {}
  std::string text;
  StatementReader reader;
  Tokens tokens;
};

std::expected<Aggregate, Fault> aggregate_of(const Statement& statement) {
  std::size_t next = 0;
  return read_aggregate(statement.tokens, next);
}

std::string reason(const std::string& text) {
  const Statement statement(text);
  const auto position = position_of(aggregate_of(statement).value(), 0);
  return position ? "" : position.error().what;
}

TEST(KrlTokens, AreNamesNumbersTextsAndSymbols) {
  EXPECT_THAT(words("PTP {A1 -90,a2 1.5E-3} C_PTP"),
              ElementsAre("PTP", "{", "A1", "-", "90", ",", "a2", "1.5E-3", "}", "C_PTP", "|"));
  EXPECT_THAT(words("$BASE=BASE_DATA[2] : #TCP \"a ; b\" 'B 01'"),
              ElementsAre("$BASE", "=", "BASE_DATA", "[", "2", "]", ":", "#TCP", "\"a ; b\"", "'B 01'", "|"));
  EXPECT_THAT(words("A=.5+5.-1.E5"), ElementsAre("A", "=", ".5", "+", "5.", "-", "1.E5", "|"));
}

TEST(KrlTokens, LeaveOutCommentsAndHeaderLines) {
  EXPECT_THAT(words("&ACCESS RVP\n  &REL 1\r\nA ; PTP \"\nB & C"), ElementsAre("A", "|", "B", "&", "C", "|"));
  EXPECT_THAT(words("\xEF\xBB\xBF&ACCESS RVP\nA"), ElementsAre("A", "|"));
}

TEST(KrlTokens, AStatementEndsWithItsLineUnlessThatEndsInAComma) {
  EXPECT_THAT(words("A\r\n\r\nB,  ; more\r\n\r\n C"), ElementsAre("A", "|", "B", ",", "C", "|"));
  EXPECT_THAT(words("A,"), ElementsAre("A", ",", "|"));
}

TEST(KrlTokens, ATextThatIsNotClosedIsAFault) {
  EXPECT_THAT(words("A\nB \"c"), ElementsAre("fault at 4"));
  EXPECT_THAT(words("it's"), ElementsAre("it", "'", "s", "|"));
}

TEST(KrlAggregate, GivesNumbersWithTheirBytes) {
  const Statement statement("{X -1.5,Y + 2, Z 'H1F',N[] \"a,}\",F {X 1,Y 2},B #BASE}");
  const auto aggregate = aggregate_of(statement);
  ASSERT_TRUE(aggregate);
  ASSERT_EQ(aggregate->fields.size(), 6U);
  const Number& x = *aggregate->find("X")->number;
  EXPECT_EQ(x.value, -1.5);
  EXPECT_EQ(statement.text.substr(x.begin, x.end - x.begin), "-1.5");
  EXPECT_EQ(aggregate->find("Y")->number->value, 2);
  EXPECT_EQ(aggregate->find("Z")->number->value, 31);
  EXPECT_FALSE(aggregate->find("N")->number);
  EXPECT_FALSE(aggregate->find("F")->number);
  EXPECT_EQ(aggregate->find("B")->word, "#BASE");
}

TEST(KrlAggregate, WhatIsNotClosedGivenTwiceOrOutOfRangeIsAFault) {
  for (const auto& [text, at] :
       {std::pair{"{X 1,Y 2", 0}, {"{X 1,Y {A 1}", 0}, {"{X 1,x 2}", 5}, {"{X 1E999}", 3}}) {
    const auto aggregate = aggregate_of(Statement(text));
    ASSERT_FALSE(aggregate) << text;
    EXPECT_EQ(aggregate.error().at, static_cast<std::size_t>(at)) << text;
  }
}

TEST(KrlAggregate, EndlessOnesAreAFault) {
  std::string text = "{";
  for (int i = 0; i < 100'000; ++i) text.append("N").append(std::to_string(i)).append(" 1,");
  const auto aggregate = aggregate_of(Statement(text + "X 1}"));
  ASSERT_FALSE(aggregate);
  EXPECT_EQ(aggregate.error().what, "too many components; give at most 256");
}

TEST(KrlPosition, IsCartesianOrOfAxesAndWhole) {
  EXPECT_EQ(reason("{POS: c 6,X 1,Y 2,Z 3,A 4,B 5,S 'B110',T 35,E1 7}"), "");
  EXPECT_EQ(reason("{A1 1,A2 2,A3 3,A4 4,A5 5,A6 6,E1 R_E1}"), "");
  EXPECT_EQ(reason("{Z 100}"), "component X is missing: it keeps what the arm has then");
  EXPECT_EQ(reason("{A1 1,A2 2,A3 3,A4 4,A5 5}"), "component A6 is missing: it keeps what the arm has then");
  EXPECT_EQ(reason("{X 1,Y 2,Z 3,A 4,B R_B,C 6}"), "component B is not a plain number");
  EXPECT_EQ(reason("{X 1,Y 2,Z 3,A 4,B 1+1,C 6}"), "component B is not a plain number");
  EXPECT_EQ(reason("{X 1,Y 2,Z 3,A 4,B 5,C 6,S 2.5}"), "component S is not a plain bit pattern");
  EXPECT_EQ(reason("{X 1,Y 2,Z 3,A 4,B 5,C 6,T -1}"), "component T is not a plain bit pattern");
}

TEST(KrlNumbers, AreWrittenWithoutNeedlessZeros) {
  EXPECT_EQ(number_text(1765), "1765.0");
  EXPECT_EQ(number_text(-0.25), "-0.25");
  EXPECT_EQ(number_text(1.0 / 3), "0.333333333");
  EXPECT_EQ(number_text(-1e-12), "0.0");
  EXPECT_EQ(number_text(std::numeric_limits<double>::max()).size(), 311U);
}

TEST(KrlRewriting, ReplacesItsBytesAlone) {
  EXPECT_EQ(rewritten("{X 1,\tY 22}\r\n", {{8, 10, "3.5"}, {3, 4, "-7.0"}}), "{X -7.0,\tY 3.5}\r\n");
  EXPECT_EQ(rewritten("abc", {}), "abc");
}

TEST(KrlRewriting, KeepsANumberApartFromItsNameWhereItsSignDidSo) {
  EXPECT_EQ(rewritten("{X-5,Y-5}", {{2, 4, "4.5"}, {6, 8, "-4.5"}}), "{X 4.5,Y-4.5}");
}

TEST(KrlPlaces, CountLinesAndColumnsFromOne) {
  const Places places("ab\r\n\nc");
  const auto at = [&](std::size_t offset) {
    const Place place = places.of(offset);
    return std::pair{place.line, place.column};
  };
  EXPECT_EQ(at(0), (std::pair{1UZ, 1UZ}));
  EXPECT_EQ(at(3), (std::pair{1UZ, 4UZ}));
  EXPECT_EQ(at(4), (std::pair{2UZ, 1UZ}));
  EXPECT_EQ(at(5), (std::pair{3UZ, 1UZ}));
}

}  // namespace
}  // namespace truepose::krl
