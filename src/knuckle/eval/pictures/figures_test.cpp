// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/figures.h"

#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/core/testing_variable.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/eval/metrics/eval_fixtures.h"
#include "knuckle/eval/pictures/gnuplot.h"
#include "knuckle/eval/pictures/score_figures.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using knuckle::testing::ChangedVariable;
using knuckle::testing::error_of;
using knuckle::testing::TemporaryFolder;
using testing::example_predictions;
using testing::example_truth;
using ::testing::HasSubstr;
using testing::is_well_formed_xml;
using ::testing::Not;

Figure small_figure(const std::vector<std::string>& names) {
  Figure figure;
  figure.name = "small";
  figure.title = "A title";
  figure.x_label = "distance (mm)";
  figure.y_label = "frames (%)";
  figure.x = {0.0, 1.0, 2.0};
  for (const std::string& name : names) figure.series.push_back({name, {0.0, kNaN, 100.0}});
  return figure;
}

TEST(XmlCheck, TellsGoodFromBad) {
  EXPECT_TRUE(is_well_formed_xml("<?xml version='1.0'?><a b=\"1>2\"><c/><d>x &amp; y</d></a>"));
  for (const char* text : {"<a><b></a></b>", "<a>", "<a/><b/>", "<a>x & y</a>", "<a b=\"<\"/>", "text"}) {
    EXPECT_FALSE(is_well_formed_xml(text)) << text;
  }
}

TEST(Figures, OfAnEvaluationAreWellFormedPicturesWithLabels) {
  const TemporaryFolder folder;
  const Truth truth = example_truth(20);
  const std::vector<Figure> figures = figures_of(evaluate(
      truth, {example_predictions(truth, "first", 5.0), example_predictions(truth, "second", 15.0)}));
  EXPECT_EQ(figures.size(), 6u);
  write_figures(figures, folder.path());
  std::set<std::string> names;
  for (const Figure& figure : figures) {
    EXPECT_TRUE(names.insert(figure.name).second);
    const std::string svg = read_text_file(folder / (figure.name + ".svg"));
    EXPECT_TRUE(is_well_formed_xml(svg)) << figure.name;
    for (const std::string& text :
         {figure.title, figure.y_label, std::string("first"), std::string("second")}) {
      EXPECT_THAT(svg, HasSubstr(text)) << figure.name;
    }
    EXPECT_GE(read_png_rgb(folder / (figure.name + ".png")).width(), 1000);
  }
}

TEST(Figures, AreTheSameBytesEveryTime) {
  const TemporaryFolder folder;
  const std::vector<Figure> figures = {small_figure({"a"})};
  write_figures(figures, folder.path());
  const std::string svg = read_text_file(folder / "small.svg");
  const std::string png = read_text_file(folder / "small.png");
  write_figures(figures, folder.path());
  EXPECT_EQ(read_text_file(folder / "small.svg"), svg);
  EXPECT_EQ(read_text_file(folder / "small.png"), png);
}

TEST(Figures, ShortenLongNamesByCharactersNotBytes) {
  const auto repeated = [](int times) {
    std::string text;
    for (int i = 0; i < times; ++i) text += "\u00e4";
    return text;
  };
  const TemporaryFolder folder;
  write_figures(std::vector{small_figure({repeated(36), repeated(40) + "end"})}, folder.path());
  const std::string svg = read_text_file(folder / "small.svg");
  EXPECT_THAT(svg, HasSubstr(">" + repeated(36) + "<"));
  EXPECT_THAT(svg, HasSubstr(">" + repeated(36) + "\u2026<"));
}

TEST(Figures, ExecuteNothingThatANameHolds) {
  const TemporaryFolder folder;
  const std::string trace = "eval_trace";  // in the working folder: a legend shortens long names
  const std::vector<std::string> names = {"'; system('touch " + trace + "'); '",
                                          "`touch " + trace + "`",
                                          "\" . system(\"touch " + trace + "\") . \"",
                                          "$(touch " + trace + ")",
                                          "a\n! touch " + trace,
                                          "a\nEND_OF_DATA\nsystem 'touch " + trace + "'",
                                          "<b>&_^{}@x %s\\n",
                                          "\u00e9\u4e2d " + std::string(80, 'x')};
  write_figures(std::vector{small_figure(names)}, folder.path());
  EXPECT_FALSE(std::filesystem::exists(trace));
  const std::string svg = read_text_file(folder / "small.svg");
  EXPECT_TRUE(is_well_formed_xml(svg));
  EXPECT_THAT(svg, HasSubstr("&lt;b>&amp;_^{}@x %s\\n"));
}

TEST(Figures, AreNamedAsAFileMayBe) {
  const TemporaryFolder folder;
  for (const std::string name : {"net-2e-4_curves", "it's my hand", "\u00e9"}) {
    Figure figure = small_figure({"a"});
    figure.name = name;
    write_figures(std::vector{figure}, folder.path());
    EXPECT_TRUE(is_well_formed_xml(read_text_file(folder / (name + ".svg")))) << name;
    EXPECT_GE(read_png_rgb(folder / (name + ".png")).width(), 1000) << name;
  }
}

TEST(Figures, EndTheirYAxisWhereTheyAreToldOrTheValuesDo) {
  const TemporaryFolder folder;
  Figure percent = small_figure({"a"});
  percent.series[0].values = {3.0, 4.0, 4.0};
  Figure millimetres = percent;
  millimetres.name = "free";
  millimetres.y = std::nullopt;
  Figure angles = percent;
  angles.name = "angles";
  angles.y = {-60.0, 30.0, 30.0};
  write_figures(std::vector{percent, millimetres, angles}, folder.path());
  EXPECT_THAT(read_text_file(folder / "small.svg"), HasSubstr("> 100<"));
  EXPECT_THAT(read_text_file(folder / "angles.svg"),
              AllOf(HasSubstr(">-60<"), HasSubstr("> 30<"), Not(HasSubstr("> 60<"))));
  EXPECT_THAT(read_text_file(folder / "free.svg"), AllOf(Not(HasSubstr("> 100<")), HasSubstr("> 4<")));
}

TEST(Figures, DrawABarGroupEachCategory) {
  const TemporaryFolder folder;
  Figure figure = small_figure({"a", "b"});
  figure.kind = FigureKind::bars;
  figure.categories = {"it's", "index_tip", "mean"};
  write_figures(std::vector{figure}, folder.path());
  const std::string svg = read_text_file(folder / "small.svg");
  EXPECT_TRUE(is_well_formed_xml(svg));
  for (const char* text : {"it's", "index_tip", "mean"}) EXPECT_THAT(svg, HasSubstr(text));
}

TEST(Figures, WithoutAKnownValueAreEmpty) {
  const TemporaryFolder folder;
  Figure bars = small_figure({"no hand", "none either"});
  bars.kind = FigureKind::bars;
  bars.categories = {"wrist", "palm", "mean"};
  for (Series& series : bars.series) series.values = {kNaN, kNaN, kNaN};
  Figure curves = bars;
  curves.kind = FigureKind::curves;
  curves.name = "curves";
  Figure free = curves;
  free.name = "free";
  free.y = std::nullopt;
  write_figures(std::vector{bars, curves, free}, folder.path());
  for (const char* name : {"small.svg", "curves.svg", "free.svg"}) {
    const std::string svg = read_text_file(folder / name);
    EXPECT_TRUE(is_well_formed_xml(svg)) << name;
    EXPECT_THAT(svg, HasSubstr("A title")) << name;
  }
}

TEST(Figures, WithoutGnuplotOneLineSaysSo) {
  const TemporaryFolder folder;
  const ChangedVariable path("PATH", folder.path().string());
  const std::string error = error_of([&] { write_figures(std::vector{small_figure({"a"})}, folder.path()); });
  EXPECT_THAT(error, AllOf(HasSubstr("gnuplot"), HasSubstr("not found"), HasSubstr("gnuplot-nox"),
                           Not(HasSubstr("\n"))));
}

TEST(Figures, AComplaintOfGnuplotIsPassedOn) {
  EXPECT_THAT(error_of([] { run_gnuplot("set nonsense 3\n"); }),
              AllOf(HasSubstr("gnuplot: "), HasSubstr("option")));
}

/// A program of that name in the folder, in place of the real one.
void write_program(const std::filesystem::path& path, const std::string& script) {
  write_text_file(path, "#!/bin/sh\n" + script + "\n");
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
}

TEST(Figures, APictureThatGnuplotLeavesIncompleteIsRefused) {
  const TemporaryFolder folder;
  write_program(
      folder / "gnuplot",
      R"sh(sed -n 's/^set output "\(.*\)"$/\1/p' "$2" | while read -r f; do echo '<svg>' >"$f"; done)sh");
  const ChangedVariable path("PATH", folder.path().string() + ":/usr/bin:/bin");
  EXPECT_THAT(error_of([&] { write_figures(std::vector{small_figure({"a"})}, folder.path()); }),
              HasSubstr("small.svg: cannot write: gnuplot left it incomplete"));
  EXPECT_FALSE(std::filesystem::exists(folder / "small.svg"));
}

TEST(Figures, AGnuplotThatCannotBeStartedIsNamed) {
  const TemporaryFolder folder;
  write_text_file(folder / "gnuplot", "no program");
  const ChangedVariable path("PATH", folder.path().string());
  EXPECT_THAT(error_of([] { run_gnuplot(""); }), HasSubstr("gnuplot: cannot be started: "));
}

TEST(Figures, AFolderForTemporaryFilesIsNeeded) {
  const ChangedVariable folder("TMPDIR", "/proc");  // where nobody can make a folder
  EXPECT_THAT(error_of([] { run_gnuplot(""); }),
              AllOf(HasSubstr("/proc/knuckle_"), HasSubstr("cannot make a temporary folder")));
}

TEST(Figures, FaultsAreNamed) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { write_figures(std::vector{small_figure({})}, folder.path()); }),
              HasSubstr("figure small: nothing to draw"));
  Figure figure = small_figure({"a"});
  figure.x.clear();
  EXPECT_THAT(error_of([&] { write_figures(std::vector{figure}, folder.path()); }),
              HasSubstr("figure small: nothing to draw"));
  figure = small_figure({"a"});
  figure.series[0].values.pop_back();
  EXPECT_THAT(error_of([&] { write_figures(std::vector{figure}, folder.path()); }),
              AllOf(HasSubstr("small"), HasSubstr("2 values"), HasSubstr("expected 3")));
  EXPECT_THAT(error_of([&] { write_figures(std::vector{small_figure({"a"})}, folder / "none"); }),
              HasSubstr("none/small.svg"));
}

TEST(GnuplotText, HoldsNothingThatGnuplotUnderstands) {
  EXPECT_EQ(gnuplot_quoted("it's"), "\"it\\047s\"");
  EXPECT_EQ(gnuplot_quoted("a\nb\tc"), "\"a b c\"");
  EXPECT_EQ(gnuplot_quoted("\\`\"$"), "\"\\134\\140\\042\\044\"");
  EXPECT_EQ(gnuplot_quoted("\u00e9 1%"), "\"\u00e9 1%\"");
}

}  // namespace
}  // namespace knuckle
