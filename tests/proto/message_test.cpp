#include "proto/text/message.hpp"

#include <gtest/gtest.h>

namespace truepose {
namespace {

enum class Fruit { Apple, Pear };
constexpr std::array kFruits{MessageKind{"F_APPLE", "{0} has {1:g} worms (limit: 0)", "throw {0} away"},
                             MessageKind{"F_PEAR", "no pear", "truepose buy {0}"}};
constexpr const MessageKind& kind_of(Fruit fruit) { return kFruits[static_cast<std::size_t>(fruit)]; }
static_assert(is_table(kFruits, "F_") && !is_table(kFruits, "L_"));
static_assert(!is_table(std::array{kFruits[1], kFruits[0]}, "F_"));

TEST(Message, IsASentenceOfWhatIsWrongAndOneOfWhatToDo) {
  const Message apple = message<Fruit::Apple>("A1", 2.0);
  EXPECT_EQ(apple.code, "F_APPLE");
  EXPECT_EQ(sentences(apple), "A1 has 2 worms (limit: 0). Throw A1 away.");
  EXPECT_EQ(sentences({"", "is it there?", ""}), "is it there?");
}

TEST(Message, LeavesACommandAFileAndAKeyAsTheyAre) {
  EXPECT_EQ(sentences(message<Fruit::Pear>(3)), "no pear. truepose buy 3.");
  EXPECT_EQ(sentences({"", "no.", "stream.listen has to change"}), "no. stream.listen has to change.");
}

TEST(Message, SaysInOneAnswerOnceWhatToDo) {
  AnswerText answer;
  EXPECT_EQ(answer.add({"", "A1 is off", "switch it on"}), "A1 is off. Switch it on.");
  EXPECT_EQ(answer.add({"", "A2 is off", "switch it on"}), "A2 is off.");
}

}  // namespace
}  // namespace truepose
