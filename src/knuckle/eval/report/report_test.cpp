// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/report/report.h"

#include <cmath>
#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/eval/metrics/eval_fixtures.h"
#include "knuckle/eval/pictures/drawing.h"
#include "knuckle/eval/pictures/score_figures.h"
#include "knuckle/eval/report/html.h"
#include "knuckle/eval/report/report_sections.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using knuckle::testing::TemporaryFolder;
using testing::example_predictions;
using testing::example_truth;
using testing::FakeSource;
using ::testing::HasSubstr;
using testing::is_well_formed_xml;
using ::testing::Not;

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + 1)) ++count;
  return count;
}

/// The document's body as XML: our pages close every element.
std::string body_of(const std::string& page) {
  const std::string begin = "<body>";
  const std::string end = "</body>";
  const std::size_t from = page.find(begin);
  std::string body = page.substr(from, page.find(end) + end.size() - from);
  for (std::size_t i = body.find("<br>"); i != std::string::npos; i = body.find("<br>"))
    body.replace(i, 4, "<br/>");
  for (std::size_t i = body.find("<img "); i != std::string::npos; i = body.find("<img ", i + 1)) {
    body.insert(body.find('>', i), 1, '/');
  }
  return body;
}

/// Two methods, one of them with a missing frame and a hostile name, over frames with images.
class ReportTest : public ::testing::Test {
 protected:
  ReportTest() {
    methods_[1].sequence.poses[4] = HandPose::missing(truth_.sequence.convention);
    report_.evaluation = evaluate(truth_, methods_);
    report_.title = "A <title>";
    report_.facts = {{"pipeline", "a & b"}};
    report_.segmentation = {score_overlaps("mean_shift", std::vector{0.9, 0.4, 0.0}, 1)};
  }

  std::string page() const { return read_text_file(write_report(report_, folder_.path())); }

  TemporaryFolder folder_;
  Truth truth_ = example_truth(12);
  std::vector<Predictions> methods_ = {example_predictions(truth_, "good", 3.0),
                                       example_predictions(truth_, "<script>alert(1)</script>", 20.0)};
  FakeSource source_{truth_};
  Report report_;
};

TEST_F(ReportTest, HoldsEveryFigureAndFile) {
  const std::string html = page();
  std::vector<Figure> figures = figures_of(*report_.evaluation);
  figures.push_back(overlap_figure(report_.segmentation));
  for (const Figure& figure : figures) {
    EXPECT_THAT(html, HasSubstr("aria-label=\"" + html_escaped(figure.title) + "\"")) << figure.name;
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "figures" / (figure.name + ".svg")));
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "figures" / (figure.name + ".png")));
  }
  EXPECT_EQ(count_of(html, "<svg "), static_cast<int>(figures.size()));
  for (const char* name : {"metrics.json", "curves.csv", "joints.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / name));
  }
}

TEST_F(ReportTest, IsWellFormedEscapedAndNeedsNothingElse) {
  report_.gallery = make_gallery({&source_, &truth_, &*report_.evaluation, methods_}, {3, 1, 128});
  const std::string html = page();
  EXPECT_TRUE(is_well_formed_xml(body_of(html)));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;"));
  EXPECT_THAT(html, HasSubstr("<h1>A &lt;title&gt;</h1>"));
  EXPECT_THAT(html, HasSubstr("a &amp; b"));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_EQ(count_of(html, "src="), count_of(html, "src=\"data:image/png;base64,iVBORw0KGgo"));
  EXPECT_EQ(count_of(html, "http"), count_of(html, "xmlns=\"http") + count_of(html, "xmlns:xlink=\"http"));
  EXPECT_EQ(count_of(html, "url("), 0);
}

TEST_F(ReportTest, HoldsMeanAndMedianOfTheOverlaps) {
  const std::string html = segmentation_section(report_.segmentation, {});
  const std::size_t mean = html.find(">0.433<");
  const std::size_t median = html.find(">0.400<");
  ASSERT_NE(mean, std::string::npos);
  ASSERT_NE(median, std::string::npos);
  EXPECT_LT(mean, median) << "in the order of their heads";
}

TEST_F(ReportTest, MarksTheBestOfEachMeasure) {
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("good</td><td class=\"best\">0</td>"));
  EXPECT_THAT(html, HasSubstr("&lt;/script&gt;</td><td>1</td>"));
}

TEST_F(ReportTest, SaysWhatWasDroppedAndMarksNoBestThen) {
  for (HandPose& pose : methods_[1].sequence.poses)
    pose = converted(pose, convention_from_name("mediapipe21"));
  methods_[1].sequence.convention = convention_from_name("mediapipe21");
  for (HandPose& pose : methods_[1].sequence.poses) pose.joints[0] = pose.joints[1] = pose.joints[2];
  report_.evaluation = evaluate(truth_, methods_);
  report_.segmentation.clear();
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("different landmarks"));
  EXPECT_THAT(html, HasSubstr("does not predict them: palm."));
  EXPECT_THAT(html, HasSubstr("has them: wrist, thumb_cmc."));
  EXPECT_THAT(html, Not(HasSubstr("class=\"best\"")));
}

TEST_F(ReportTest, HowFarConfidencesAreTrueIsDrawnWhereThereAreAny) {
  FollowedScore score;
  score.name = "sure";
  report_.followed = {score};
  EXPECT_THAT(page(), Not(HasSubstr("by their confidence")));
  report_.followed[0].reliability.bins[7] = {400, 0.75, 0.5};
  report_.followed[0].reliability.bins[2] = {19, 0.25, 0.5};
  report_.followed[0].reliability.joints = 419;
  report_.followed[0].reliability.error = 0.25;
  EXPECT_THAT(page(), HasSubstr("by their confidence"));
  EXPECT_THAT(read_text_file(folder_ / "metrics.json"), HasSubstr("\"within_20mm\": 0.5"));
  const Figure figure = reliability_figure(report_.followed);
  ASSERT_EQ(figure.series.size(), 2u);
  EXPECT_EQ(figure.series[0].values[7], 50.0);
  EXPECT_TRUE(std::isnan(figure.series[0].values[2])) << "too few joints";
  EXPECT_NEAR(figure.series[1].values[7], 75.0, 1e-9);
}

TEST_F(ReportTest, VisibleAndHiddenLandmarksStandApart) {
  FollowedScore score;
  score.name = "sure";
  score.occlusion[static_cast<std::size_t>(Occluder::none)] = {300, 7.25, 0.9, 0.8};
  score.occlusion[static_cast<std::size_t>(Occluder::object)] = {100, 21.75, 0.5, 0.4};
  report_.followed = {score};
  EXPECT_THAT(page(), ::testing::AllOf(HasSubstr(">7.25<"), HasSubstr(">21.75<")));
  const std::string json = read_text_file(folder_ / "metrics.json");
  EXPECT_THAT(json, HasSubstr("\"object\": {\n          \"joints\": 100,\n          \"mean_3d_mm\": 21.75"));
  EXPECT_THAT(json, Not(HasSubstr("\"border\"")));
}

TEST_F(ReportTest, DifferencesOfTwoMethodsAreATable) {
  ASSERT_EQ(report_.evaluation->differences.size(), 1u);
  report_.evaluation->differences[0] = {.first = 0,
                                        .second = 1,
                                        .frames = 11,
                                        .block_frames = 1,
                                        .mean_mm = -17.254,
                                        .low_mm = -18.5,
                                        .high_mm = 0.125,
                                        .p_value = 0.0312};
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("<h2>Differences</h2>"));
  EXPECT_THAT(html, HasSubstr("<td>11</td>"));
  EXPECT_THAT(html, HasSubstr("-17.25"));
  EXPECT_THAT(html, HasSubstr("-18.50 to +0.12"));
  EXPECT_THAT(html, HasSubstr("0.031"));
  EXPECT_EQ(count_of(html, "<script>"), 0) << "names are escaped";
  // Where too few frames have a pose of both nothing is said, not a number that is none.
  report_.evaluation->differences[0].mean_mm = kNaN;
  EXPECT_THAT(page(), Not(HasSubstr("Differences")));
}

TEST_F(ReportTest, WithoutTruthThereIsAGallery) {
  const FakeSource source;
  Report report;
  const std::span<const Predictions> first(methods_.data(), 1);
  report.gallery = make_gallery({&source, nullptr, nullptr, first}, {4, 1, 128});
  EXPECT_EQ(report.gallery.size(), 4u);
  for (const GalleryRow& row : report.gallery) {
    ASSERT_EQ(row.pictures.size(), 2u);
    EXPECT_EQ(row.pictures[0].caption, "whole frame");
    const auto is_outline = [](const Rgb& pixel) { return pixel == kEstimateColour; };
    EXPECT_TRUE(std::ranges::any_of(row.pictures[0].picture.pixels(), is_outline)) << "where the crop lies";
  }
  const std::string html = read_text_file(write_report(report, folder_ / "plain"));
  EXPECT_TRUE(is_well_formed_xml(body_of(html)));
  EXPECT_EQ(count_of(html, "<img "), 8);
  EXPECT_THAT(html, Not(HasSubstr("truth")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "plain" / "metrics.json"));
}

TEST_F(ReportTest, ATableOfTextsIsEscaped) {
  const std::string html = table_section({"Times & more", {"method", "ms"}, {{"a<b", "1.5"}}, "measured"});
  EXPECT_TRUE(is_well_formed_xml("<body>" + html + "</body>"));
  EXPECT_THAT(html, HasSubstr("<h2>Times &amp; more</h2>"));
  EXPECT_THAT(html, HasSubstr("<td>a&lt;b</td><td>1.5</td>"));
}

TEST_F(ReportTest, ATableOfNumbersMarksTheBestAndLeavesOutWhatIsNotKnown) {
  const std::string html = number_table(
      "method", {"one", "two"}, {{"a", {2.0, 1.0}, 1, Better::lower}, {"b", {0.5, kNaN}, 1, Better::higher}});
  EXPECT_THAT(html, HasSubstr("<td>two</td><td class=\"best\">1.0</td><td>\u2013</td>"));
  EXPECT_THAT(html, HasSubstr("<td>one</td><td>2.0</td><td class=\"best\">0.5</td>"));
}

TEST_F(ReportTest, AnUnwritableFolderIsNamed) {
  write_text_file(folder_ / "file", "");
  EXPECT_THAT(error_of([&] { write_report(report_, folder_ / "file"); }), HasSubstr("file"));
}

TEST_F(ReportTest, GalleryShowsEvenlySpreadAndWorstFrames) {
  const std::vector<GalleryRow> rows =
      make_gallery({&source_, &truth_, &*report_.evaluation, methods_}, {3, 1, 128});
  std::set<std::string> captions;
  for (const GalleryRow& row : rows) {
    EXPECT_TRUE(captions.insert(row.caption).second);
    EXPECT_TRUE(row.shows_truth);
    ASSERT_EQ(row.pictures.size(), 2u);
    for (const GalleryPicture& picture : row.pictures) EXPECT_EQ(picture.picture.width(), 128);
  }
  EXPECT_THAT(rows[0].caption, HasSubstr("Frame 2 (frame2)"));
  EXPECT_THAT(rows[1].caption, HasSubstr("Frame 6 (frame6)"));
  EXPECT_THAT(rows[2].caption, HasSubstr("Frame 10 (frame10)"));
  // A missing prediction is the worst of all.
  const auto worst = std::ranges::find_if(rows, [](const GalleryRow& row) {
    return row.caption.find("Frame 4 (frame4): worst of <script>") != std::string::npos;
  });
  ASSERT_NE(worst, rows.end());
  EXPECT_EQ(worst->pictures[1].note, "no hand");
  EXPECT_THAT(worst->pictures[0].note, HasSubstr(" mm"));
}

TEST_F(ReportTest, GalleryWorksWithoutImages) {
  const std::vector<GalleryRow> rows = make_gallery({nullptr, &truth_, nullptr, methods_}, {2, 0, 100});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].caption, "Frame 3");
  const auto is_estimate = [](const Rgb& pixel) { return pixel == Rgb{0xff, 0x8c, 0x1a}; };
  EXPECT_TRUE(std::ranges::any_of(rows[0].pictures[0].picture.pixels(), is_estimate));
}

TEST(GalleryOptions, AreChecked) {
  EXPECT_THAT(error_of([] { make_gallery({}, {8, 1, 10}); }), HasSubstr("picture_size_px"));
}

TEST(Html, EscapesAndEncodes) {
  EXPECT_EQ(html_escaped("<a href=\"x\">'&\n"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp; ");
  const auto encoded = [](std::string_view text) {
    return base64(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  };
  // Test vectors of RFC 4648, section 10.
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
  EXPECT_THAT(error_of([] { inline_svg("nothing", "figure"); }), HasSubstr("figure"));
}

}  // namespace
}  // namespace knuckle
