#include "app/output/svg_plot.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "app/output/html_text.h"
#include "tests/app/output/html_check.h"

namespace pathfit::app {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

std::string Plot(std::vector<double> x, std::vector<double> y, bool log_y = false) {
  PlotOptions options;
  options.title = "t <&>";
  options.log_y = log_y;
  options.stage_lines = {{0.5, "a"}, {kNan, "b"}, {1e9, "c"}};
  options.crosses = {{1.0, 2.0}, {kNan, 1.0}, {1.0, -1.0}};
  const std::string svg = SvgLinePlot(options, {{"s", std::move(x), std::move(y)}});
  EXPECT_EQ(HtmlFault(svg), "");
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_EQ(svg.find("style="), std::string::npos);
  return svg;
}

TEST(SvgLinePlot, SaysThatThereIsNoData) {
  for (const bool log_y : {false, true}) {
    EXPECT_EQ(Count(Plot({}, {}, log_y), "No data."), 1);
    EXPECT_EQ(Count(Plot({1.0, 2.0}, {kNan, kInf}, log_y), "No data."), 1);
  }
  EXPECT_EQ(Count(Plot({1.0, 2.0}, {0.0, -1.0}, true), "No data."), 1);
}

TEST(SvgLinePlot, DrawsASinglePointAsADot) {
  for (const bool log_y : {false, true}) {
    EXPECT_EQ(Count(Plot({3.0}, {2.0}, log_y), "class=\"dot"), 1);
    EXPECT_EQ(Count(Plot({1.0, 2.0, 3.0}, {kNan, 2.0, kNan}, log_y), "class=\"dot"), 1);
  }
}

TEST(SvgLinePlot, InterruptsTheLineAtBadValues) {
  const std::string svg =
      Plot({1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, {1.0, 2.0, kNan, 4.0, 0.0, 6.0}, true);
  EXPECT_EQ(Count(svg, "class=\"dot"), 2) << svg;
  EXPECT_EQ(Count(Plot({1.0, 2.0, 3.0, 4.0}, {1.0, kInf, 3.0, 4.0}), "class=\"dot"), 1);
}

TEST(SvgLinePlot, KeepsExtremeAndConstantDataInsideThePicture) {
  for (const bool log_y : {false, true}) {
    Plot({1.0, 2.0}, {1e-140, 1e140}, log_y);
    Plot({1.0, 1.0}, {5.0, 5.0}, log_y);
    Plot({1e12, 1e12 + 1.0}, {1e300, 1.0}, log_y);
    Plot({0.0, 1.0}, {1.0, 1.0 + 1e-15}, log_y);
  }
}

TEST(SvgLinePlot, ThinsLongCurves) {
  std::vector<double> x, y;
  for (int i = 0; i < 100000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(0.001 * i));
  }
  EXPECT_LT(Plot(x, y).size(), 60000U);
}

TEST(SvgBars, CopeWithEmptyAndBadValues) {
  PlotOptions options;
  for (const std::string& svg : {SvgBars(options, {}),
                                 SvgBars(options, {{"<a>", {kNan}}, {"b", {}}, {"c", {-3.0}}}),
                                 SvgStackedBars(options, {}, {}),
                                 SvgStackedBars(options, {"p"}, {{"x", {kNan, -1.0}}}),
                                 SvgStackedBars(options, {"p", "q"}, {{"<x>", {1.0, 2.0, 3.0}}})}) {
    EXPECT_EQ(HtmlFault(svg), "");
    EXPECT_EQ(svg.find("nan"), std::string::npos);
  }
}

TEST(Ticks, CoverTheRangeWithRoundNumbers) {
  EXPECT_EQ(LinearTicks(0.0, 10.0, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(LinearTicks(1.0, 1.0, 5).size(), 1U);
  EXPECT_EQ(LogTicks(0.9e-3, 1.1e1), (std::vector<double>{1e-3, 1e-2, 1e-1, 1.0, 10.0}));
  EXPECT_GE(LogTicks(1.1, 1.3).size(), 2U);
  EXPECT_LE(LogTicks(1e-100, 1e100).size(), 12U);
}

TEST(HtmlText, EscapesEverythingThatIsMarkup) {
  EXPECT_EQ(EscapeHtml("<a href=\"x\">'&'</a>"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(EscapeHtml("é→\n\t"), "é→\n\t");
  EXPECT_EQ(EscapeHtml(std::string("\x01\x7f\xff\xc3", 4)),
            "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");
  EXPECT_EQ(EscapeHtml("\xc0\xbc\xed\xa0\x80").find("\xc0"), std::string::npos);
}

TEST(HtmlText, WritesNumbersForPeople) {
  EXPECT_EQ(NumberText(0.0), "0");
  EXPECT_EQ(NumberText(-1.5), "−1.5");
  EXPECT_EQ(NumberText(1e-5), "10⁻⁵");
  EXPECT_EQ(NumberText(3.214e-6), "3.214·10⁻⁶");
  EXPECT_EQ(NumberText(123456.0), "1.235·10⁵");
  EXPECT_EQ(NumberText(kNan), "–");
  EXPECT_EQ(NumberText(-kInf), "−∞");
  EXPECT_EQ(FixedText(-0.001, 2, "dB"), "0.00 dB");
  EXPECT_EQ(FixedText(27.314, 2, "dB"), "27.31 dB");
  EXPECT_EQ(BytesText(812345.0), "813 kB");
  EXPECT_EQ(BytesText(3.44e6), "3.4 MB");
}

}  // namespace
}  // namespace pathfit::app
