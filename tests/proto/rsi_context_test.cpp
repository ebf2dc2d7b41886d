// Ordinals as in the contexts of kuka-external-control-sdk (RSI 4.1), kuka_rsi_driver and rsi-pi (RSI 3),
// which ran on controllers.
#include <gmock/gmock.h>

#include <pugixml.hpp>

#include "config/text_file.hpp"
#include "proto/rsi/context.hpp"
#include "tests/rsi_flaws.hpp"

namespace truepose::rsi {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ResultOf;

const std::string kShipped = std::string{TRUEPOSE_SOURCE_DIR} + "/config/kuka/rsi/";

EthernetConfig shipped_ethernet() {
  return parse_ethernet_config(config::read_text_file(kShipped + "truepose_rsi_ethernet.xml")).value();
}

std::string attribute(const std::string& xml, const std::string& xpath) {
  pugi::xml_document document;
  EXPECT_TRUE(document.load_string(xml.c_str()));
  return document.select_node(xpath.c_str()).attribute().value();
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(Context, ComesBackFromEveryFormat) {
  const Context context = truepose_context({});
  for (const ContextFormat format :
       {ContextFormat::RsiXml, ContextFormat::Rsix40, ContextFormat::Rsix, ContextFormat::Rsix6}) {
    const auto read = parse_context(context_xml(context, format));
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(*read, context);
  }
}

TEST(Context, HasTheOrdinalsOfItsFormat) {
  const std::string old = context_xml(truepose_context({}), ContextFormat::RsiXml),
                    now = context_xml(truepose_context({}), ContextFormat::Rsix);
  const auto in_old = [&](const std::string& type, const std::string& rest) {
    return attribute(old, "//RSIObject[@ObjType='" + type + "']" + rest);
  };
  const auto in_now = [&](const std::string& type, const std::string& rest) {
    return attribute(now, "//RsiObject[@ObjType='" + type + "']" + rest);
  };
  EXPECT_EQ(in_old("AXISCORR", "//Parameter[@Name='UpperLimA1']/@ParamID"), "13");
  EXPECT_EQ(in_now("AxisCorr", "//Parameter[@Name='UpperLimA1']/@ParamId"), "6");
  EXPECT_EQ(in_old("AXISCORR", "//Input[@InIdx='1']/@OutIdx"), "1");
  EXPECT_EQ(in_now("AxisCorr", "//Input[@InIdx='0']/@OutIdx"), "0");
  EXPECT_EQ(in_old("ETHERNET", "//Parameter[@Name='Precision']/@ParamID"), "8");
  EXPECT_EQ(in_now("Ethernet", "//Parameter[@Name='Precision']/@ParamId"), "7");
  EXPECT_EQ(in_now("Ethernet", "//Parameter[@Name='Timeout']/@ParamId"), "0");
  EXPECT_EQ(in_now("Ethernet", "//Parameter[@Name='ConfigFile']/@IsRuntime"), "false");
  EXPECT_EQ(in_old("STOP", "//Parameter[@Name='Mode']/@ParamID"), "1");
  EXPECT_EQ(in_now("Sen_PInt", "/@ObjTypeId"), "57");
  EXPECT_EQ(in_now("Map2Sen_PInt", "/@ObjTypeId"), "16");
  EXPECT_EQ(in_old("STATUS", "/@ObjTypeID"), "62");
}

TEST(Context, OfRsi40HasTheOrdinalsOf41BelowARootOfItsOwn) {
  const std::string early = context_xml(truepose_context({}), ContextFormat::Rsix40),
                    now = context_xml(truepose_context({}), ContextFormat::Rsix);
  EXPECT_EQ(attribute(early, "/RsiContext/@Version"), "0.1.0");
  EXPECT_EQ(attribute(early, "/RsiContext/@SchemaVersion"), "");
  EXPECT_EQ(attribute(now, "/RsiContext/@SchemaVersion"), "2.0.0");
  const auto objects = [](const std::string& xml) { return xml.substr(xml.find("<RsiObject ")); };
  EXPECT_EQ(objects(early), objects(now));
}

TEST(Context, IsReadWithTypesInAnyLetterCase) {
  const Context context = truepose_context({});
  for (const char* name : {"OV_PRO", "Ov_Pro", "ov_pro"}) {
    const auto read = parse_context(
        changed(context_xml(context, ContextFormat::Rsix), "\"OV_PRO\"", "\"" + std::string{name} + "\""));
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(*read, context);
  }
}

TEST(Context, OfRsi3TellsExternalAxesByNameWhereTheNumberIsShared) {
  const auto context = parse_context(R"(<RSIObjects>
    <RSIObject ObjType="ETHERNET" ObjTypeID="64" ObjID="ETHERNET1"/>
    <RSIObject ObjType="AXISACT" ObjTypeID="32" ObjID="AXISACT1">
      <Parameters><Parameter Name="Type" ParamID="1" ParamValue="0"/></Parameters>
    </RSIObject>
    <RSIObject ObjType="AXISCORREXT" ObjTypeID="33" ObjID="AXISCORREXT1">
      <Inputs><Input InIdx="7" OutObjID="ETHERNET1" OutIdx="9"/></Inputs>
      <Parameters><Parameter Name="LowerLimE1" ParamID="7" ParamValue="-2"/></Parameters></RSIObject></RSIObjects>)");
  ASSERT_TRUE(context) << context.error();
  const ContextObject* const external = context->of_type("AXISCORREXT");
  EXPECT_EQ(external->inputs.at(1), (ContextOutput{"ETHERNET1", 9}));
  EXPECT_EQ(external->number("LowerLimE1"), -2);
  ASSERT_NE(context->of_type("AXISACT"), nullptr);
  EXPECT_EQ(context->of_type("AXISACT")->number("Type"), 0);
}

TEST(Context, IsReadTogetherWithUnknownObjects) {
  const auto context = parse_context(R"(<RSIObjects>
    <RSIObject ObjType="FUTURE" ObjTypeID="246" ObjID="FUTURE1">
      <Parameters><Parameter Name="Type" ParamID="1" ParamValue="0"/></Parameters></RSIObject>
    <RSIObject ObjType="ETHERNET" ObjTypeID="64" ObjID="ETHERNET1">
      <Inputs><Input InIdx="2" OutObjID="FUTURE1" OutIdx="6"/></Inputs></RSIObject></RSIObjects>)");
  ASSERT_TRUE(context) << context.error();
  EXPECT_EQ(context->objects[0].type, "FUTURE");
  EXPECT_EQ(context->of_type("ETHERNET")->inputs.at(2), (ContextOutput{"FUTURE1", 6}));
}

TEST(Context, ThatCannotBeMeantIsRefusedInOneSentence) {
  const std::string old = context_xml(truepose_context({}), ContextFormat::RsiXml);
  const auto error = [](const std::string& xml) {
    const auto context = parse_context(xml);
    return context ? "" : context.error();
  };
  EXPECT_THAT(error(changed(old, R"(Name="UpperLimA1" ParamID="13")", R"(Name="UpperLimA1" ParamID="6")")),
              AllOf(HasSubstr("AXISCORR1: UpperLimA1"), HasSubstr("another parameter: it is 13")));
  EXPECT_THAT(error(changed(old, R"(InIdx="1")", R"(InIdx="0")")), HasSubstr("expected 1 or more"));
  EXPECT_THAT(error(changed(old, R"(ObjTypeID="18")", R"(ObjTypeID="33")")),
              HasSubstr("STOP1: ObjTypeID 33 is AXISCORR, but ObjType says STOP"));
  EXPECT_THAT(error(changed(old, R"(InIdx="2")", R"(InIdx="1")")), HasSubstr("is wired twice"));
  EXPECT_THAT(error(changed(old, R"(ObjID="STATUS1")", R"(ObjID="STATUS9")")),
              HasSubstr("is wired to STATUS1, which is not there"));
  EXPECT_THAT(error(changed(old, R"(ObjID="STATUS1")", R"(ObjID="SEN_PINT1")")),
              HasSubstr("two objects SEN_PINT1"));
  EXPECT_THAT(error(changed(old, R"(Name="Type" ParamID="1" ParamValue="5")",
                            R"(Name="Type" ParamID="1" ParamValue="9")")),
              HasSubstr("STATUS2: Type is \"9\", expected 0 to 8"));
  EXPECT_THAT(error(changed(old, R"(OutObjID="STATUS2" OutIdx="1")", R"(OutObjID="STATUS2" OutIdx="2")")),
              HasSubstr("input 3 is wired to output 2 of STATUS2, but STATUS has 1"));
  EXPECT_THAT(error(changed(old, R"(InIdx="6")", R"(InIdx="7")")), HasSubstr("AXISCORR has 6 inputs"));
  EXPECT_THAT(error("<ROOT/>"), HasSubstr("no RSI context"));
  EXPECT_THAT(error("<RSIObjects"), HasSubstr("not an XML document"));
}

TEST(Context, OfEveryPrefixAndWithAnyByteChangedIsReadOrRefused) {
  const std::string text = context_xml(truepose_context({}), ContextFormat::Rsix);
  for (std::size_t size = 0; size < text.size(); ++size)
    static_cast<void>(parse_context(text.substr(0, size)));
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string damaged = text;
    damaged[at] = '9';
    if (const auto read = parse_context(damaged)) static_cast<void>(lint(*read, shipped_ethernet(), {}));
  }
}

TEST(Context, OfTruePoseIsTheShippedOneAndHasNothingToComplainOf) {
  EXPECT_THAT(lint(truepose_context({}), shipped_ethernet(), {}), IsEmpty());
  EXPECT_EQ(config::read_text_file(kShipped + "truepose_rsi.rsi.xml"),
            context_xml(truepose_context({}), ContextFormat::RsiXml));
  EXPECT_EQ(config::read_text_file(kShipped + "truepose_rsi.rsix"),
            context_xml(truepose_context({}), ContextFormat::Rsix));
}

auto is_about(std::string_view code, const std::string& sentence) {
  return AllOf(Field(&Message::code, code), ResultOf(sentences, HasSubstr(sentence)));
}

TEST(ContextLint, NamesEveryFlawAlone) {
  for (const ContextFlaw& flaw : context_flaws()) {
    Context context = truepose_context({});
    flaw.make(context);
    EXPECT_THAT(lint(context, shipped_ethernet(), {}),
                ElementsAre(is_about(kind_of(flaw.kind).code, flaw.found)))
        << flaw.found;
  }
}

TEST(ContextLint, SaysWhatACartesianCorrectionDoes) {
  const auto read = parse_context(R"(<RsiContext><RsiObjects>
    <RsiObject ObjTypeId="64" ObjType="Ethernet" ObjId="ETHERNET1"><Parameters>
      <Parameter Name="ConfigFile" ParamId="0" ParamValue="truepose_rsi_ethernet.xml"/>
      <Parameter Name="Timeout" ParamId="0" ParamValue="100"/><Parameter Name="Precision" ParamId="7" ParamValue="4"/>
    </Parameters></RsiObject>
    <RsiObject ObjTypeId="27" ObjType="PosCorr" ObjId="PosCorr_1">
      <Inputs><Input InIdx="0" OutObjId="ETHERNET1" OutIdx="0"/><Input InIdx="1" OutObjId="ETHERNET1" OutIdx="1"/></Inputs>
      <Parameters><Parameter Name="UpperLimZ" ParamId="5" ParamValue="25"/>
        <Parameter IsRuntime="false" Name="RefCorrSys" ParamId="0" ParamValue="1"/></Parameters></RsiObject>
    <RsiObject ObjTypeId="81" ObjType="PosCorrMon" ObjId="PosCorrMon_1">
      <Parameters><Parameter Name="MaxTrans" ParamId="0" ParamValue="45"/></Parameters></RsiObject>
    </RsiObjects></RsiContext>)");
  ASSERT_TRUE(read) << read.error();
  EXPECT_THAT(
      lint(*read, shipped_ethernet(), {}),
      Contains(is_about(
          "L_POSCORR",
          "PosCorr_1: moves the TCP along the base by what AK brings (X -5 .. 5 mm, Y -5 .. 5 mm, Z -5 .. "
          "25 mm, 5 deg; POSCORRMON stops RSI at 45 mm or 6 deg), but truepose sends nothing for it.")));
}

TEST(ContextLint, KnowsTheLimitsThatHoldWhereNoneAreGiven) {
  Context context = truepose_context({.max_total_deg = 7});
  object_of(context, "AXISCORR").values.clear();
  std::erase_if(context.objects, [](const auto& o) { return o.type == "AXISCORRMON"; });
  const auto findings = lint(context, shipped_ethernet(), {.max_total_deg = 7});
  ASSERT_EQ(findings.size(), 12U);
  EXPECT_THAT(findings[0], is_about("L_CLAMP", "to -5 .. 5 deg (stream.max_total_deg: 7 deg)"));
  EXPECT_THAT(findings[6], is_about("L_CEILING", "AXISCORRMON (default): RSI stops at 6 deg of A1"));
}

}  // namespace
}  // namespace truepose::rsi
