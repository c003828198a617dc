// Records of contacts against the events that were sent of them.
#include <vector>

#include "contact/event_balance.h"
#include "support/aborts.h"
#include "support/catch.h"

using namespace feder;
using test::aborts;

TEST_CASE("records of contacts are live, in order, once, and have begun without an end", "[couple]") {
  if (!kAsserts) return;
  struct Record {
    ObjectId a, b;
  };
  Objects objects;
  const ObjectId cloth = objects.add(ObjectKind::cloth, 0, "", 0), one = objects.add(ObjectKind::body, 0, "", 0),
                 two = objects.add(ObjectKind::body, 1, "", 0);
  const auto fails = [&](const std::vector<Record>& records, int begun, int ended) {
    EventBalance balance;
    for (int k = 0; k < begun; ++k) balance.count(EventKind::contact_begin);
    for (int k = 0; k < ended; ++k) balance.count(EventKind::contact_end);
    balance.count(EventKind::contact_stay), balance.count(EventKind::hit);
    return aborts([&] {
      validate_records<Record>(records, &Record::a, ObjectKind::cloth, &Record::b, ObjectKind::body, objects, balance);
    });
  };
  CHECK_FALSE(fails({}, 0, 0));
  CHECK_FALSE(fails({{cloth, one}, {cloth, two}}, 3, 1));
  CHECK(fails({{cloth, one}}, 2, 0));                // removed without its end event
  CHECK(fails({{cloth, one}}, 1, 1));                // ended, and still there
  CHECK(fails({{cloth, one}, {cloth, two}}, 1, 0));  // came without its begin event
  CHECK(fails({{cloth, two}, {cloth, one}}, 2, 0));
  CHECK(fails({{cloth, one}, {cloth, one}}, 2, 0));
  CHECK(fails({{one, cloth}}, 1, 0));
  objects.remove(one, "");
  CHECK(fails({{cloth, one}}, 1, 0));
}
