#include "io/bytes/xml_scan.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::bytesOf;
using samples::errorOf;

/// The document as nested lists: name{space}[attribute=value]'text'(children).
std::string listed(const std::string& document) {
  const Input input{bytesOf(document), "a.3mf"};
  XmlScanner xml(input, "p");
  std::string result;
  const auto element = [&](const auto& self) -> void {
    const size_t depth = xml.depth();
    result += std::string(xml.name()) + (xml.space().empty() ? "" : "{" + std::string(xml.space()) + "}");
    for (const XmlScanner::Attribute& each : xml.attributes()) {
      result += "[" + (each.space.empty() ? "" : std::string(each.space) + "|") + std::string(each.name) + "=" +
                std::string(each.value) + "]";
    }
    if (xml.name() == "t") {
      result += "'" + xml.text() + "'";
      return;
    }
    result += "(";
    while (xml.child(depth)) self(self);
    result += ")";
  };
  xml.root();
  element(element);
  xml.finish();
  return result;
}

void expectRefused(const std::string& document, const char* because) {
  const std::string error = errorOf([&] { (void)listed(document); });
  EXPECT_EQ(error.find("a.3mf: part \"p\", line "), 0u) << error;
  EXPECT_NE(error.find(because), std::string::npos) << document << " -> " << error;
}

TEST(XmlScan, ElementsAttributesAndSpaces) {
  EXPECT_EQ(listed("<a/>"), "a()");
  EXPECT_EQ(listed("\xef\xbb\xbf<?xml version='1.0' encoding='utf-8' ?>\n<!-- <b> --><a x = '1'\ty=\"'\" ><b /><?pi "
                   "<c> ?><b></b >x</a>\n<!---->"),
            "a[x=1][y='](b()b())");
  EXPECT_EQ(listed("<a xmlns='u' xmlns:p='v'><p:b p:x='1' x='2'/><b xmlns=''/><b xmlns='w'><p:c/><d/></b><e/></a>"),
            "a{u}(b{v}[v|x=1][x=2]()b()b{w}(c{v}()d{w}())e{u}())");
  EXPECT_EQ(listed("<a xml:lang='en'/>"), "a[http://www.w3.org/XML/1998/namespace|lang=en]()");
}

TEST(XmlScan, TextAndEntities) {
  EXPECT_EQ(listed("<t>a &lt;&#65;&#x20AC;&amp;lt; <b>no</b>\r\n<![CDATA[<&]]>z</t>"), "t'a <A\xe2\x82\xac&lt; \n<&z'");
  EXPECT_EQ(listed("<a x='&quot;1\n2\t&apos;' y='&#x1F600;'/>"), "a[x=\"1 2 '][y=\xf0\x9f\x98\x80]()");
  EXPECT_EQ(listed("<t>&#228;&#x7FF;&#x80;</t>"), "t'\xc3\xa4\xdf\xbf\xc2\x80'");
  expectRefused("<t>&nbsp;</t>", "entity \"nbsp\"");
  expectRefused("<t>&</t>", "'&' stands alone");
  expectRefused("<a x='&#0;'/>", "is not known");
  expectRefused("<a x='&#xD800;'/>", "is not known");
  expectRefused("<a x='&#99999999999;'/>", "is not known");
  expectRefused("<a x='\x01'/>", "control character");
}

TEST(XmlScan, TextIsValidUtf8) {
  EXPECT_EQ(listed("<t>\xc3\xa4\xef\xbf\xbd\xf4\x8f\xbf\xbf</t>"), "t'\xc3\xa4\xef\xbf\xbd\xf4\x8f\xbf\xbf'");
  for (const char* bad :
       {"\xff", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xc3", "\xc3(", "\x80"}) {
    expectRefused("<t>" + std::string(bad) + "</t>", "no valid UTF-8");
  }
}

TEST(XmlScan, WhatCannotBeTrustedIsRefused) {
  expectRefused("<!DOCTYPE a [<!ENTITY b 'c'>]><a/>", "document type");
  expectRefused("<a><!ENTITY b 'c'></a>", "document type");
  expectRefused("\xff\xfe<\0a", "UTF-16");
  expectRefused("<?xml version='1.0' encoding='ISO-8859-1'?><a/>", "ISO-8859-1");
  std::string deep;
  for (int i = 0; i < 65; ++i) deep += "<a>";
  expectRefused(deep, "nested");
  std::string wide = "<a";
  for (int i = 0; i < 65; ++i) wide += " x" + std::to_string(i) + "=''";
  expectRefused(wide + "/>", "attributes");
  std::string spaces = "<a><b";
  for (int i = 0; i < 40; ++i) spaces += " xmlns:x" + std::to_string(i) + "='u'";
  std::string again = spaces;
  EXPECT_EQ(listed(spaces + "/></a>"), "a(b())");
  expectRefused(spaces + ">" + again.substr(3) + "/></b></a>", "namespaces");
}

TEST(XmlScan, WhatIsNotWellFormedIsRefused) {
  for (const auto& [document, because] :
       std::initializer_list<std::pair<const char*, const char*>>{{"", "no element"},
                                                                  {"x<a/>", "outside"},
                                                                  {"<a/>x", "outside"},
                                                                  {"<a/><b/>", "second"},
                                                                  {"<a></b>", "not closed"},
                                                                  {"<a><b></a>", "not closed"},
                                                                  {"</a>", "not closed"},
                                                                  {"<a x/>", "no value"},
                                                                  {"<a x=1/>", "no quotes"},
                                                                  {"<a x='1'y='2'/>", "no blank"},
                                                                  {"<a x='1' x='2'/>", "twice"},
                                                                  {"<a x='<'/>", "within a value"},
                                                                  {"<1/>", "a name should"},
                                                                  {"<a/ >", "within a tag"},
                                                                  {"<p:a/>", "stands for nothing"},
                                                                  {"<a p:x=''/>", "stands for nothing"},
                                                                  {"<a><!-- -- --></a>", "a comment"},
                                                                  {"<a></a b>", "more than a name"},
                                                                  {"<![CDATA[]]><a/>", "document type"}}) {
    expectRefused(document, because);
  }
}

TEST(XmlScan, ACutInAnAttributeIsNoMissingValue) {
  for (const char* cut : {"<a b", "<a b ", "<a b=", "<a b= ", "<a b=\"c"}) expectRefused(cut, "cut off");
}

TEST(XmlScan, EveryCutIsNoticed) {
  const std::string document =
      "<?xml version='1.0'?><a x='1&amp;' xmlns:p='q'><!-- c --><p:b p:y='2'/><![CDATA[x]]><t>d</t><?e f?></a>";
  ASSERT_FALSE(listed(document).empty());
  for (size_t length = 0; length < document.size(); ++length)
    (void)errorOf([&] { (void)listed(document.substr(0, length)); });
}

TEST(XmlScan, MessagesNameTheLine) {
  EXPECT_EQ(errorOf([] { (void)listed("<a>\n<b>\n</c></b></a>"); }).find("a.3mf: part \"p\", line 3: "), 0u);
}

}  // namespace
}  // namespace argil::io
