"""The description of the interface: every refusal, who may call, and what an address takes."""

import re

import jsonschema_rs
import pytest

from app.edge.description import describe
from app.edge.documentation import render
from app.edge.examples import example


@pytest.fixture
def description(application):
    return describe(application)


def answers(description, method, path):
    return set(description["paths"][path][method]["responses"])


def test_refusals_follow_from_what_a_route_is_made_of(description):
    assert answers(description, "get", "/api/me") == {"200", "401", "403", "503"}
    assert "404" not in answers(description, "get", "/api/patients")
    assert answers(description, "get", "/api/patients/{patient_id}") == {
        *("200", "401", "403", "404", "409", "422", "503")
    }
    assert {"401", "413", "422", "429"} <= answers(description, "post", "/api/sign-in")
    assert "404" not in answers(description, "post", "/api/sign-in")


def test_each_refusal_has_the_one_shape(description):
    assert "HTTPValidationError" not in description["components"]["schemas"]
    for response in description["components"]["responses"].values():
        assert response["content"]["application/json"]["schema"] == {"$ref": "#/components/schemas/ErrorOut"}
    assert "Retry-After" in description["components"]["responses"]["Error503"]["headers"]


def test_who_may_call_is_said(description):
    paths = description["paths"]
    assert paths["/api/me"]["get"]["security"] == [{"browser": []}]
    assert paths["/api/sessions/{session_id}"]["get"]["security"] == [{"browser": []}, {"device": []}]
    assert "security" not in paths["/api/sign-in"]["post"]
    changing = paths["/api/sessions"]["post"]["parameters"]
    assert [one["name"] for one in changing] == ["X-CSRF-Token"]


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("GET", "/api/sign-in", "POST"),
        ("TRACE", "/api/health", "GET"),
        ("PUT", "/api/sessions/x", "DELETE, GET, PATCH"),
    ],
)
def test_a_method_that_an_address_does_not_take_is_answered_with_those_that_it_does(
    nobody, method, path, allowed
):
    answer = nobody.request(method, path)
    assert answer.status_code == 405
    assert answer.headers["Allow"] == allowed
    assert answer.json()["code"] == "method_not_allowed"


def test_numbers_are_no_dates_and_no_flags(therapist, world):
    path = f"/api/patients/{world.patient_id}"
    for body in ({"birth_date": 0}, {"is_archived": 0}, {"notes": None}):
        answer = therapist.patch(path, json=body)
        assert answer.status_code == 422, body
        assert next(iter(body)) in answer.text


def test_a_body_that_is_no_json_is_input_that_is_not_understood(therapist, world):
    answer = therapist.patch(
        f"/api/patients/{world.patient_id}", content=b"\xff\xfe", headers={"Content-Type": "application/json"}
    )
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid_input")


def test_the_page_shows_code_as_code_and_an_example_of_what_a_route_takes(application):
    page = render(describe(application))
    assert "`" not in page
    assert "&quot;patient_id&quot;: &quot;text&quot;" in page
    assert "Nobody is signed in" in page


def test_every_example_fits_its_schema(description):
    schemas = description["components"]["schemas"]
    for path, operations in description["paths"].items():
        for operation in operations.values():
            for kind, media in operation.get("requestBody", {}).get("content", {}).items():
                if kind != "application/json":
                    continue
                schema = {**media["schema"], "components": description["components"]}
                problems = [
                    error.message
                    for error in jsonschema_rs.Draft202012Validator(schema).iter_errors(
                        example(media["schema"], schemas)
                    )
                ]
                assert problems == [], path


def test_a_text_in_a_query_has_no_nul(description):
    texts = [
        schema
        for path in description["paths"].values()
        for operation in path.values()
        for parameter in operation.get("parameters", ())
        if parameter["in"] == "query"
        for schema in (parameter["schema"], *parameter["schema"].get("anyOf", ()))
        if schema.get("type") == "string" and not {"enum", "const", "format"} & schema.keys()
    ]
    assert texts
    assert not [one for one in texts if re.search(one["pattern"], "a\0b")]
