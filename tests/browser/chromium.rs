//! Chromium without a window, and what the tests do with it.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::skips::skip;
use fantoccini::elements::Element;
use fantoccini::{Client, ClientBuilder, Locator};
use serde_json::{Value, json};

/// How long the browser may take to show something.
const PATIENCE: Duration = Duration::from_secs(60);

/// Size of the window.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    width: u32,
    height: u32,
}

impl Look {
    pub const WIDE: Look = Look {
        width: 1200,
        height: 900,
    };
    pub const NARROW: Look = Look {
        width: 390,
        height: 840,
    };
}

pub struct Browser {
    driver: Child,
    pub client: Client,
}

fn found(program: &str) -> Option<PathBuf> {
    let paths = std::env::var_os("PATH")?;
    std::env::split_paths(&paths)
        .map(|folder| folder.join(program))
        .find(|path| path.exists())
}

/// The accessibility checker's script: `VELOID_AXE`, or where `.ci/run` puts it.
pub fn axe() -> Option<String> {
    let put = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../target/axe/node_modules/axe-core/axe.min.js");
    let path = std::env::var_os("VELOID_AXE").map_or(put, PathBuf::from);
    let script = std::fs::read_to_string(&path).ok();
    if script.is_none() {
        skip(&format!("no axe-core at {}", path.display()));
    }
    script
}

/// How often chromedriver is started.
const STARTS: usize = 5;

/// A chromedriver and its port; none where it ended before it listened.
fn listening(driver: &Path) -> Option<(Child, String)> {
    let mut driver = Command::new(driver)
        .arg("--port=0")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(driver.stdout.take().unwrap()).lines();
    let port = lines.by_ref().map_while(Result::ok).find_map(|line| {
        let port = line.split_once("successfully on port ")?.1;
        Some(port.trim_end_matches('.').to_owned())
    });
    let Some(port) = port else {
        driver.wait().unwrap();
        return None;
    };
    std::thread::spawn(move || lines.for_each(drop));
    Some((driver, port))
}

impl Browser {
    /// None, with a word about it, where there is no Chromium.
    pub async fn start(look: Look) -> Option<Self> {
        let (Some(chromium), Some(driver)) = (found("chromium"), found("chromedriver")) else {
            skip("no chromium with chromedriver");
            return None;
        };
        // Several that start at once may choose one port: the others end.
        let (driver, port) = (0..STARTS)
            .find_map(|_| listening(&driver))
            .expect("chromedriver ended before it listened");
        // A phone's width is below what a window may have, so it is emulated.
        let options = json!({
            "binary": chromium,
            "args": ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"],
            "mobileEmulation": {"deviceMetrics": {
                "width": look.width, "height": look.height, "pixelRatio": 1.0, "touch": false, "mobile": false}},
        });
        let capabilities = json!({"goog:chromeOptions": options})
            .as_object()
            .unwrap()
            .clone();
        let client = ClientBuilder::new(hyper_util::client::legacy::connect::HttpConnector::new())
            .capabilities(capabilities)
            .connect(&format!("http://127.0.0.1:{port}"))
            .await
            .unwrap();
        Some(Self { driver, client })
    }

    pub async fn stop(mut self) {
        let _ = self.client.clone().close().await;
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }

    pub async fn goto(&self, url: &str) {
        self.client.goto(url).await.unwrap();
        let watch = "addEventListener('securitypolicyviolation', (event) => \
                     (window.violations ??= []).push(`${event.violatedDirective} ${event.sample}`))";
        self.run(watch).await;
    }

    pub async fn find(&self, css: &str) -> Element {
        let found = self
            .client
            .wait()
            .at_most(PATIENCE)
            .for_element(Locator::Css(css))
            .await;
        found.unwrap_or_else(|error| panic!("{css}: {error}"))
    }

    /// The value of a script.
    pub async fn run(&self, script: &str) -> Value {
        self.client.execute(script, vec![]).await.unwrap()
    }

    /// Asks until the answer is enough.
    pub async fn until(&self, script: &str, enough: impl Fn(&Value) -> bool) -> Value {
        let ask = async {
            loop {
                // A page that is just being left answers nothing.
                if let Ok(value) = self.client.execute(script, vec![]).await
                    && enough(&value)
                {
                    return value;
                }
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        };
        match tokio::time::timeout(PATIENCE, ask).await {
            Ok(value) => value,
            Err(_) => panic!("{script} gave {} to the end", self.run(script).await),
        }
    }

    /// Waits until the part of the page holds the text.
    pub async fn sees(&self, css: &str, text: &str) {
        let script = format!("return document.querySelector({css:?})?.innerText ?? null");
        self.until(&script, |seen| {
            seen.as_str().is_some_and(|seen| seen.contains(text))
        })
        .await;
    }

    /// Brings an element into view, with the part of the page that holds it unfolded.
    pub async fn scroll(&self, css: &str) {
        self.find(css).await;
        self.run(&format!(
            "const found = document.querySelector({css:?}); \
             let part = (found.matches('summary') ? found.parentElement : found).parentElement.closest('details'); \
             for (; part; part = part.parentElement.closest('details')) part.open = true; \
             found.scrollIntoView({{ block: 'center' }})"
        ))
        .await;
    }

    pub async fn click(&self, css: &str) {
        self.scroll(css).await;
        self.find(css).await.click().await.unwrap();
    }

    pub async fn fill(&self, css: &str, text: &str) {
        let field = self.find(css).await;
        field.clear().await.unwrap();
        field.send_keys(text).await.unwrap();
    }

    pub async fn choose(&self, css: &str, value: &str) {
        self.find(css).await;
        // By the option's value, which need not stand in an attribute.
        let script = format!(
            "const field = document.querySelector({css:?}); field.value = {value:?}; \
             field.dispatchEvent(new Event('change', {{ bubbles: true }})); return field.value"
        );
        assert_eq!(self.run(&script).await, value, "{css}");
    }

    pub async fn press(&self, css: &str, keys: &str) {
        self.scroll(css).await;
        self.find(css).await.send_keys(keys).await.unwrap();
    }

    /// Waits until every plot that is in sight has been drawn.
    pub async fn settled(&self) {
        self.until(
            "return document.readyState === 'complete' && \
             [...document.querySelectorAll('.plot.waiting')].every((plot) => { \
               const { top, bottom } = plot.getBoundingClientRect(); \
               return plot.closest('[hidden], details:not([open])') || bottom < 0 || top > innerHeight; })",
            |settled| settled == true,
        )
        .await;
    }

    /// Serious and critical faults of access on the page.
    pub async fn check(&self, axe: &str) -> Value {
        self.run(axe).await;
        let script = "const done = arguments[arguments.length - 1]; \
            axe.run().then(({ violations }) => done(violations \
              .filter(({ impact }) => impact === 'serious' || impact === 'critical') \
              .map(({ id, nodes }) => [id, nodes.map(({ html }) => html.slice(0, 200))])))";
        self.client.execute_async(script, vec![]).await.unwrap()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.driver.kill();
    }
}
