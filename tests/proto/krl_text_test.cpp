// Tokens, aggregates and the rewriting of numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "proto/krl/places.hpp"
#include "proto/krl/position.hpp"
#include "proto/krl/program_statement.hpp"
#include "proto/krl/rewrite.hpp"

namespace truepose::krl {
namespace {

using testing::ElementsAre;

std::vector<std::string> words(std::string_view text) {
  const auto statements = cut_into_statements(text);
  if (!statements) return {"fault at " + std::to_string(statements.error().at)};
  std::vector<std::string> result;
  for (const Statement& statement : *statements) {
    for (const Token& token : statement) result.emplace_back(token.text);
    result.emplace_back("|");
  }
  return result;
}

/// An expression that is a whole statement, and the text to which it refers.
struct Whole {
  explicit Whole(std::string text_in)
      : text(std::move(text_in)), statement(cut_into_statements(text).value().at(0)) {
    TokenReader reader(statement);
    expression = read_expression(reader);
    reader.expect_end();
  }
  std::string text;
  Statement statement;
  Expression expression;
};

std::string reason(const std::string& text) {
  const auto position = position_of(Whole(text).expression, 0);
  return position ? "" : position.error().what;
}

/// What read_statements() says of a text.
Fault fault(const std::string& text) { return read_statements(text).error(); }

TEST(KrlTokens, AreNamesNumbersTextsAndSymbols) {
  EXPECT_THAT(words("PTP {A1 -90,a2 1.5E-3} C_PTP"),
              ElementsAre("PTP", "{", "A1", "-", "90", ",", "a2", "1.5E-3", "}", "C_PTP", "|"));
  EXPECT_THAT(words("$BASE=BASE_DATA[2] : #TCP \"a ; b\" 'B 01'"),
              ElementsAre("$BASE", "=", "BASE_DATA", "[", "2", "]", ":", "#TCP", "\"a ; b\"", "'B 01'", "|"));
  EXPECT_THAT(words("A=.5+5.-1.E5"), ElementsAre("A", "=", ".5", "+", "5.", "-", "1.E5", "|"));
  EXPECT_THAT(words("A.B<=M[1].5"), ElementsAre("A", ".", "B", "<=", "M", "[", "1", "]", ".", "5", "|"));
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

TEST(KrlTokens, KnowTheirLinesWordsAndNumbers) {
  const auto statements = cut_into_statements("a\n\nX,  ; more\n#tcp \"a b\" 'H1f' 1.5 1E999").value();
  ASSERT_EQ(statements.size(), 2U);
  const Statement& last = statements[1];
  EXPECT_EQ(statements[0][0].line, 1);
  EXPECT_EQ(last[0].line, 3);
  EXPECT_EQ(last[2].line, 4);
  EXPECT_EQ(statements[0][0].word(), "A");
  EXPECT_EQ(last[2].word(), "TCP");
  EXPECT_EQ(last[3].word(), "a b");
  EXPECT_EQ(last[4].number(), 31);
  EXPECT_EQ(last[5].number(), 1.5);
  EXPECT_FALSE(last[6].number());
  EXPECT_FALSE(last[0].number());
}

TEST(KrlAggregate, GivesNumbersWithTheirBytes) {
  const Whole whole("{X -1.5,Y + 2, Z 'H1F',N[] \"a,}\",F {X 1,Y 2},B #BASE}");
  const Expression& aggregate = whole.expression;
  ASSERT_EQ(aggregate.names.size(), 6U);
  EXPECT_EQ(aggregate.text(), whole.text);
  const Number x = number_of(*aggregate.find("X")).value();
  EXPECT_EQ(x.value, -1.5);
  EXPECT_EQ(whole.text.substr(x.begin, x.end - x.begin), "-1.5");
  EXPECT_EQ(number_of(*aggregate.find("Y"))->value, 2);
  EXPECT_EQ(number_of(*aggregate.find("Z"))->value, 31);
  EXPECT_FALSE(number_of(*aggregate.find("N")));
  EXPECT_FALSE(number_of(*aggregate.find("F")));
  EXPECT_EQ(aggregate.find("B")->name, "BASE");
  EXPECT_FALSE(aggregate.find("C"));
}

TEST(KrlAggregate, WhatIsNotClosedGivenTwiceOrOutOfRangeIsAFault) {
  EXPECT_EQ(fault("P={X 1,Y 2").at, 2U);
  EXPECT_EQ(fault("P={X 1,Y {A 1}").at, 2U);
  EXPECT_EQ(fault("P={X 1,x 2}").at, 7U);
  EXPECT_EQ(fault("P={X 1E999}").at, 5U);
  EXPECT_EQ(fault("LIN P:{X -1E999}").at, 10U);
}

TEST(KrlAggregate, EndlessOnesAreAFault) {
  std::string text = "P={";
  for (int i = 0; i < 100'000; ++i) text.append("N").append(std::to_string(i)).append(" 1,");
  EXPECT_EQ(fault(text + "X 1}").what, "too many components; give at most 256");
}

TEST(KrlVariables, HaveARootAndATextOfTheirOwn) {
  const Whole whole("1+Grid[2 , 1].x");
  const Expression& variable = whole.expression.parts[1];
  EXPECT_TRUE(variable.is_variable());
  EXPECT_EQ(variable.text(), "Grid[2 , 1].x");
  EXPECT_EQ(variable.name, "X");
  EXPECT_EQ(variable.root().name, "GRID");
  EXPECT_FALSE(whole.expression.is_variable());
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
