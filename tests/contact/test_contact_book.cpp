// The contact book: begins and ends alternate and come once per pair, whichever finder reports the contacts.
#include "state/contact_book.h"
#include "support/aborts.h"
#include "support/catch.h"

using namespace feder;
using test::aborts;

namespace {

constexpr ObjectKind kBody{"body", "bodies"}, kCloth{"cloth", "cloths"}, kWater{"fluid", "fluids"};

// A book with two bodies, a cloth and a fluid.
struct Desk {
  Arena arena{"test"};
  Objects objects{kBody, kCloth, kWater};
  Events events{arena};
  ContactBook book{arena};
  ObjectId one = objects.add(kBody, 0, "", 0), two = objects.add(kBody, 1, "", 0),
           cloth = objects.add(kCloth, 0, "", 0), water = objects.add(kWater, 0, "", 0);
  std::uint32_t sheets = book.finder("sheets"), pools = book.finder("pools");
  std::uint64_t step = 0;

  ContactFinding finding(ObjectId a, ObjectId b, std::uint32_t index = 0, Real impulse = 1) const {
    ContactFinding n;
    n.key = {a, b};
    n.index = index, n.impulse = impulse, n.speed = 2 * impulse, n.slip = 3 * impulse;
    return n;
  }
  void count(ObjectId a, ObjectId b, int change) {
    ContactFinding n = finding(a, b);
    n.change = change;
    book.count(n);
  }
  std::vector<Event> merge() {
    events.clear();
    book.merge(step++, objects, events);
    events.finish();
    book.validate(objects, events);
    return {events.list().begin(), events.list().end()};
  }
  // The only event of the next step; without one: a step.
  EventKind only() {
    const std::vector<Event> all = merge();
    CHECK(all.size() <= 1);
    return all.empty() ? EventKind::step : all[0].kind;
  }
};

constexpr EventKind kNothing = EventKind::step;

}  // namespace

TEST_CASE("a pair touches while one of its contacts is counted, or somebody sees it", "[contact][events]") {
  Desk d;
  d.book.use();
  CHECK(d.only() == kNothing);
  d.count(d.one, d.two, 1);
  CHECK(d.only() == EventKind::contact_begin);
  d.count(d.one, d.two, 1);
  CHECK(d.only() == kNothing);
  d.count(d.one, d.two, -1);
  d.book.see(d.sheets, d.finding(d.one, d.two));
  CHECK(d.only() == kNothing);
  d.count(d.one, d.two, -1);
  d.book.see(d.sheets, d.finding(d.one, d.two));
  CHECK(d.only() == kNothing);
  CHECK(d.book.records().size() == 1);
  CHECK(d.only() == EventKind::contact_end);  // nobody sees it any more
  d.count(d.one, d.two, 1), d.count(d.one, d.two, -1);
  CHECK(d.only() == kNothing);  // came and went between two merges
  CHECK(d.book.records().empty());
}

TEST_CASE("what two finders see is one contact, and lasts until both have lost it", "[contact][events]") {
  Desk d;
  d.book.see(d.pools, d.finding(d.cloth, d.two));
  d.book.see(d.sheets, d.finding(d.cloth, d.two));
  d.book.see(d.sheets, d.finding(d.cloth, d.one));
  CHECK(d.merge().size() == 2);
  int seen = 0;
  d.book.each(d.sheets, [&](const ContactRecord&) { ++seen; });
  CHECK(seen == 2);
  d.book.see(d.pools, d.finding(d.cloth, d.two));
  d.book.each(d.sheets, [&](const ContactRecord& r) {
    if (r.key.b == d.one) d.book.keep(d.sheets, r);  // neither moves
  });
  CHECK(d.only() == kNothing);
  const std::vector<Event> ends = d.merge();
  REQUIRE(ends.size() == 2);
  for (const Event& e : ends) CHECK(e.kind == EventKind::contact_end);
}

TEST_CASE("events of a pair tell where, how hard and how many", "[contact][events]") {
  Desk d;
  d.events.set_wanted(EventKind::hit, true), d.events.set_wanted(EventKind::contact_stay, true);
  ContactFinding wet = d.finding(d.one, d.water, 7);
  wet.number = 1, wet.point = Vec3(1, 2, 3), wet.normal = Vec3(0, 1, 0);
  d.book.see(d.pools, wet);
  std::vector<Event> all = d.merge();
  REQUIRE(all.size() == 2);
  CHECK(all[0].kind == EventKind::contact_begin);
  CHECK(all[0].index == 7);
  CHECK(all[0].point == Vec3(1, 2, 3));
  CHECK(all[1].kind == EventKind::hit);
  CHECK(all[1].speed == 2);
  CHECK(all[1].impulse == 1);
  d.book.see(d.pools, wet);
  d.book.see(d.sheets, d.finding(d.one, d.water, 4, Real(0.5)));
  all = d.merge();
  REQUIRE(all.size() == 1);
  CHECK(all[0].kind == EventKind::contact_stay);
  CHECK(all[0].impulse == Real(1.5));
  CHECK(all[0].slip == 3);
  d.book.each(d.pools, [&](const ContactRecord& r) { d.book.keep(d.pools, r); });
  CHECK(d.merge().empty());  // sleepers are not reported
  all = d.merge();
  REQUIRE(all.size() == 1);
  CHECK(all[0].kind == EventKind::contact_end);
  CHECK(all[0].index == 0);  // particles: none
  CHECK(all[0].point == Vec3(1, 2, 3));
  d.book.see(d.sheets, d.finding(d.cloth, d.one, 4, Real(0.01)));
  CHECK(d.only() == EventKind::contact_begin);  // too slow for a hit
}

TEST_CASE("contacts of the dead end, sensors enter and leave", "[contact][events]") {
  Desk d;
  ContactFinding inside = d.finding(d.one, d.water, 3);
  inside.key.sensor = 1, inside.number = 1;
  d.book.see(d.pools, inside);
  d.book.see(d.sheets, d.finding(d.cloth, d.one));
  std::vector<Event> all = d.merge();
  REQUIRE(all.size() == 2);
  CHECK(all[0].kind == EventKind::contact_begin);
  CHECK(all[1].kind == EventKind::sensor_enter);
  CHECK(all[1].index == 3);
  d.objects.remove(d.one, "");
  d.book.see(d.sheets, d.finding(d.cloth, d.one));  // its finder has not noticed
  all = d.merge();
  REQUIRE(all.size() == 2);
  CHECK(all[0].kind == EventKind::contact_end);
  CHECK(all[1].kind == EventKind::sensor_leave);
  CHECK(all[1].index == 0);
}

TEST_CASE("the contact book goes on from an image", "[contact][snapshot]") {
  Desk d;
  d.book.see(d.sheets, d.finding(d.cloth, d.one));
  d.count(d.one, d.two, 1);
  CHECK(d.merge().size() == 2);
  d.count(d.one, d.two, -1);  // waits for the next merge
  std::string image;
  Writer w(image);
  d.book.save(w);
  CHECK(d.merge().size() == 2);
  CHECK(d.book.records().empty());
  Reader r(image);
  d.book.load(r);
  CHECK(r.at_end());
  CHECK(d.book.records().size() == 2);
  CHECK(d.merge().size() == 2);
}

TEST_CASE("what the contact book cannot be told stops where asserts are on", "[contact]") {
  if (!kAsserts) return;
  CHECK(aborts([] {
    Desk d;
    d.count(d.one, d.two, -1);  // it never began
    d.merge();
  }));
  CHECK(aborts([] {
    Desk d;
    d.book.see(3, d.finding(d.one, d.two));
  }));
  CHECK(aborts([] {
    Desk d;
    d.count(d.one, d.one, 1);
  }));
  CHECK(aborts([] {
    Desk d;
    d.book.see(d.sheets, d.finding(d.cloth, d.one));
    d.book.merge(0, d.objects, d.events);
    d.events.clear();  // its begin was lost
    d.book.validate(d.objects, d.events);
  }));
  CHECK(aborts([] {
    Desk d;
    d.book.see(d.sheets, d.finding(d.cloth, d.one));
    d.merge();
    d.objects.remove(d.one, "");
    d.book.validate(d.objects, d.events);  // its end was not reported
  }));
}
