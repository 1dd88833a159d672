use crate::formats::markup::*;

fn kind(xml: &str) -> &'static str {
    let mut markup = Markup::new();
    // However it is cut.
    let mut cut = xml.as_bytes().chunks(997);
    let fed = cut.try_for_each(|piece| markup.feed(piece, &mut |_, _| Ok(())));
    fed.err().map_or("", |problem| problem.kind())
}

fn cell(inside: &str) -> String {
    format!("<x:c r='A1'><x:is>{inside}</x:is></x:c>")
}

#[test]
fn a_text_is_bounded_however_it_is_written() {
    for (one, most) in [
        ("a", TEXT),
        ("\u{fc}", TEXT),
        ("&amp;", TEXT),
        ("&#65;", TEXT),
    ] {
        assert_eq!(kind(&cell(&one.repeat(most))), "", "{one}");
        assert_eq!(kind(&cell(&one.repeat(most + 1))), "part-too-long", "{one}");
    }
    let long = "a".repeat(TEXT / 2 + 1);
    for parts in [
        format!("<r><t>{long}</t></r><r><t>{long}</t></r>"),
        format!("<t>{long}<!-- -->{long}</t>"),
        format!("<t>{long}<x/>{long}</t>"),
        format!("<t>{long}<![CDATA[{long}]]></t>"),
    ] {
        assert_eq!(kind(&cell(&parts)), "part-too-long");
    }
    let apart = format!("<c><f>{long}</f><v>{long}</v></c>");
    assert_eq!(kind(&apart.repeat(3)), "", "a formula is not its value");
    assert_eq!(kind(&format!("<si><t>{long}</t></si>").repeat(9)), "");
    assert_eq!(kind(&" ".repeat(TEXT + 1)), "part-too-long");
}

#[test]
fn markup_is_bounded() {
    let long = "a".repeat(TAG);
    for xml in [
        format!("<c r=\"{long}\"/>"),
        format!("<!--{long}-->"),
        format!("<?{long}?>"),
        format!("<{long}>"),
        format!("<![CDATA[{long}]]>"),
        cell(&"<r/>".repeat(ITEM / 4)),
        cell(&format!("&{}", "a".repeat(ITEM))),
    ] {
        assert_eq!(kind(&xml), "part-too-long", "{}", &xml[..20]);
    }
    assert_eq!(kind(&"<c/>".repeat(ITEM)), "", "many short ones");
    assert_eq!(kind(&"<a>".repeat(DEPTH + 1)), "corrupt-file");
}

#[test]
fn what_readers_may_understand_otherwise_is_refused() {
    for xml in [
        "<is></c>",
        "</c>",
        "<!-->",
        "<!--->",
        "<?>",
        "<!DOCTYPE x>",
        "<>",
        "<a></a \">\">",
        "<\0c>",
        "<?xml version='1.0' encoding='utf-16'?>",
    ] {
        assert_eq!(kind(xml), "corrupt-file", "{xml}");
    }
    let sound = "\u{feff}<?xml version='1.0' encoding='UTF-8'?><!-- > --><a b='>' c=\"'\"><b /><![CDATA[<]]]></a >";
    assert_eq!(kind(sound), "");
}
